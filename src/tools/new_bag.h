/// A bag that appears at its place only when it is complete.
#pragma once

#include <ros/message_traits.h>
#include <rosbag/bag.h>

#include <boost/make_shared.hpp>
#include <filesystem>
#include <string>

namespace predictive_stereo {

/// Written beside its place as PATH.partial, moved there by complete(), removed without it.
class NewBag {
 public:
  explicit NewBag(const std::string& path) : path_(path), partial_(path + ".partial") {
    bag_.open(partial_, rosbag::bagmode::Write);
  }
  ~NewBag() {
    if (complete_) return;
    try {
      bag_.close();
    } catch (const std::exception&) {
      // It is removed anyway.
    }
    std::error_code ignored;
    std::filesystem::remove(partial_, ignored);
  }
  NewBag(const NewBag&) = delete;
  NewBag& operator=(const NewBag&) = delete;

  void compress() { bag_.setCompression(rosbag::compression::LZ4); }

  template <class Message>
  void write(const std::string& topic, const ros::Time& time, const Message& message) {
    bag_.write(topic, time, message);
  }

  /// As written by a latching publisher: players latch it again.
  template <class Message>
  void writeLatched(const std::string& topic, const ros::Time& time, const Message& message) {
    const auto header = boost::make_shared<ros::M_string>();
    (*header)["type"] = ros::message_traits::datatype(message);
    (*header)["md5sum"] = ros::message_traits::md5sum(message);
    (*header)["message_definition"] = ros::message_traits::definition(message);
    (*header)["latching"] = "1";
    (*header)["callerid"] = "/predictive_stereo";
    bag_.write(topic, time, message, header);
  }

  void complete() {
    bag_.close();
    std::filesystem::rename(partial_, path_);
    complete_ = true;
  }

 private:
  std::string path_, partial_;
  rosbag::Bag bag_;
  bool complete_ = false;
};

}  // namespace predictive_stereo
