#include "nodelets/message_pool.h"

#include <gtest/gtest.h>

#include <set>

namespace predictive_stereo {
namespace {

using Pool = MessagePool<std::vector<int>>;

TEST(MessagePool, memory_is_used_again_once_everybody_has_let_go) {
  Pool pool;
  auto first = pool.take();
  first->resize(100);
  const std::vector<int>* address = first.get();
  const boost::shared_ptr<const std::vector<int>> subscriber = first;
  first.reset();
  EXPECT_NE(pool.take().get(), address) << "a subscriber still looks at it";
}

TEST(MessagePool, a_returned_message_keeps_its_memory) {
  Pool pool;
  auto first = pool.take();
  first->resize(100);
  const int* data = first->data();
  first.reset();
  const auto again = pool.take();
  EXPECT_EQ(again->data(), data);
  EXPECT_EQ(again->size(), 100u);
}

TEST(MessagePool, messages_in_flight_are_different_ones) {
  Pool pool;
  std::vector<boost::shared_ptr<std::vector<int>>> held;
  std::set<std::vector<int>*> addresses;
  for (int i = 0; i < 40; ++i) {
    held.push_back(pool.take());
    addresses.insert(held.back().get());
  }
  EXPECT_EQ(addresses.size(), held.size());
}

TEST(MessagePool, hoarded_messages_are_not_kept) {
  Pool pool;
  std::vector<boost::shared_ptr<std::vector<int>>> held;
  for (int i = 0; i < 40; ++i) held.push_back(pool.take());
  size_t kept = 0;
  for (const auto& message : held) kept += message.use_count() > 1;
  EXPECT_EQ(kept, 16u);
}

TEST(MessagePool, messages_outlive_their_pool) {
  boost::shared_ptr<std::vector<int>> message;
  {
    Pool pool;
    message = pool.take();
    message->assign(10, 3);
  }
  EXPECT_EQ(message.use_count(), 1);
  EXPECT_EQ(message->at(9), 3);
}

}  // namespace
}  // namespace predictive_stereo
