#include "evaluation/simulation/street.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "evaluation/simulation/scene.h"

namespace predictive_stereo {
namespace {

using Eigen::Vector3d;

StreetParams smallStreet(const std::string& scene) {
  StreetParams params;
  params.scene = scene;
  params.width = 400;
  params.height = 120;
  params.frames = 100;
  return params;
}

// Only geometry: no noise, no mirrors, the same exposure in both cameras.
simulation::Scene plain(const std::string& name) {
  simulation::Scene scene = simulation::sceneByName(name);
  scene.sensor.noise = scene.sensor.shot_noise = scene.sensor.exposure_swing = 0;
  scene.sensor.right_gain = 1;
  scene.sensor.right_offset = 0;
  scene.look.reflections = 0;
  return scene;
}

constexpr int kTextured = 4;  // grey levels over two pixels

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

bool same(const StreetFrame& a, const StreetFrame& b) {
  return same(a.left, b.left) && same(a.right, b.right) && same(a.disparity_px, b.disparity_px) &&
         same(a.moving_id, b.moving_id) && a.T_world_cam.matrix() == b.T_world_cam.matrix() &&
         a.movers.size() == b.movers.size();
}

// The largest difference of disparities around a pixel.
float jumpAround(const cv::Mat1f& disparity, int x, int y, int radius) {
  double low, high;
  cv::minMaxLoc(disparity(cv::Rect(x - radius, y - radius, 2 * radius + 1, 2 * radius + 1)), &low,
                &high);
  return static_cast<float>(high - low);
}

float bilinear(const cv::Mat1b& image, double x, double y) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const double fx = x - x0, fy = y - y0;
  const int x1 = std::min(x0 + 1, image.cols - 1), y1 = std::min(y0 + 1, image.rows - 1);
  return static_cast<float>((1 - fy) * ((1 - fx) * image(y0, x0) + fx * image(y0, x1)) +
                            fy * ((1 - fx) * image(y1, x0) + fx * image(y1, x1)));
}

// Disparity of the nearest surface that the left camera sees at each pixel of the right image.
cv::Mat1f nearestOnTheRight(const StreetFrame& frame) {
  cv::Mat1f nearest(frame.left.size(), 0.0f);
  for (int y = 0; y < nearest.rows; ++y)
    for (int x = 0; x < nearest.cols; ++x) {
      const double x_right = x - frame.disparity_px(y, x);
      for (const double side : {std::floor(x_right), std::ceil(x_right)})
        if (side >= 0 && side < nearest.cols) {
          float& there = nearest(y, static_cast<int>(side));
          there = std::max(there, frame.disparity_px(y, x));
        }
    }
  return nearest;
}

// Mean brightness difference between the images at smooth visible pixels, where the right image is
// sampled `error_px` beside the true disparity. Only pixels with a horizontal gradient count,
// because others do not depend on the disparity.
double photometricError(const StreetFrame& frame, double error_px) {
  const cv::Mat1f nearest = nearestOnTheRight(frame);
  double sum = 0;
  int count = 0;
  for (int y = 4; y < frame.left.rows - 4; ++y) {
    for (int x = 4; x < frame.left.cols - 4; ++x) {
      const float d = frame.disparity_px(y, x);
      if (d == 0 || jumpAround(frame.disparity_px, x, y, 2) > 0.7f) continue;
      const double x_right = x - d + error_px;
      if (x_right < 1 || x_right > frame.right.cols - 2) continue;
      if (nearest(y, static_cast<int>(std::lround(x_right))) > d + 0.7f) continue;  // occluded
      if (std::abs(frame.left(y, x + 1) - frame.left(y, x - 1)) < kTextured) continue;
      sum += std::abs(bilinear(frame.right, x_right, y) - frame.left(y, x));
      ++count;
    }
  }
  EXPECT_GT(count, frame.left.rows * frame.left.cols / 40);
  return sum / count;
}

// The same between a frame and the previous one, warped by true disparity and true motion, without
// moving objects. The previous image is sampled `error_px` beside the true position.
double photometricError(const StereoRig& rig, const StreetFrame& before, const StreetFrame& after,
                        const cv::Point2d& error_px) {
  const Eigen::Isometry3d T_before_after =
      before.T_world_cam.inverse(Eigen::Isometry) * after.T_world_cam;
  double sum = 0;
  int count = 0;
  for (int y = 4; y < rig.size.height - 4; ++y)
    for (int x = 4; x < rig.size.width - 4; ++x) {
      const float d = after.disparity_px(y, x);
      if (d == 0 || after.moving_id(y, x) || jumpAround(after.disparity_px, x, y, 2) > 0.7f)
        continue;
      const int contrast = std::max(std::abs(after.left(y, x + 1) - after.left(y, x - 1)),
                                    std::abs(after.left(y + 1, x) - after.left(y - 1, x)));
      if (contrast < kTextured) continue;
      const Vector3d there =
          rig.disparityFromPoint(T_before_after * rig.pointFromDisparity(x, y, d));
      const double u = there.x() + error_px.x, v = there.y() + error_px.y;
      if (u < 3 || v < 3 || u > rig.size.width - 4 || v > rig.size.height - 4) continue;
      // Occluded in the previous frame?
      const cv::Point at(static_cast<int>(std::lround(u)), static_cast<int>(std::lround(v)));
      if (std::abs(before.disparity_px(at) - there.z()) > 0.7) continue;
      sum += std::abs(bilinear(before.left, u, v) - after.left(y, x));
      ++count;
    }
  EXPECT_GT(count, rig.size.area() / 40);
  return sum / count;
}

TEST(Street, RoadAheadIsAPlaneBelowTheCamera) {
  StreetParams params;
  params.frames = 40;
  const Street street(params, plain("static"));
  for (const int index : {0, 17, 39}) {
    const StreetFrame frame = street.render(index);
    const StereoRig& rig = street.rig();
    for (int y = 300; y < rig.size.height; y += 3) {
      for (int x = 590; x < 630; x += 3) {
        const Vector3d ray((x - rig.cx_left_px) / rig.fx_px, (y - rig.cy_px) / rig.fy_px, 1);
        const double depth_m =
            -frame.T_world_cam.translation().z() / (frame.T_world_cam.linear() * ray).z();
        ASSERT_NEAR(frame.disparity_px(y, x), rig.disparityTimesDepth() / depth_m, 1e-3)
            << "pixel " << x << ", " << y << " of frame " << index;
      }
    }
  }
}

TEST(Street, SkyIsInfinitelyFar) {
  const Street street(smallStreet("static"));
  const StreetFrame frame = street.render(0);
  const int sky =
      frame.disparity_px.rows * frame.disparity_px.cols - cv::countNonZero(frame.disparity_px);
  EXPECT_GT(sky, 400);
  EXPECT_LT(sky, 400 * 120 / 2);
}

// A frame with much content for each body and site.
const std::pair<const char*, int> kInstants[] = {{"street", 35}, {"turn", 35},  {"leader", 35},
                                                 {"drone", 140}, {"robot", 40}, {"handheld", 110}};

StreetParams largerStreet(const std::string& scene) {
  StreetParams params = smallStreet(scene);
  params.width = 800;
  params.height = 240;
  params.frames = 300;
  return params;
}

TEST(Street, ImagesAgreeUnderTheTrueDisparity) {
  for (const auto& [scene, index] : kInstants) {
    const Street street(largerStreet(scene), plain(scene));
    const StreetFrame frame = street.render(index);
    const double exact = photometricError(frame, 0);
    EXPECT_LT(exact, 5) << scene;
    for (const double error_px : {-1.0, 1.0})
      EXPECT_GT(photometricError(frame, error_px), 1.5 * exact) << scene << " " << index;
  }
}

TEST(Street, ImagesAgreeUnderTheTrueMotion) {
  for (const auto& [scene, index] : kInstants) {
    const Street street(largerStreet(scene), plain(scene));
    const StreetFrame before = street.render(index - 1), after = street.render(index);
    const double exact = photometricError(street.rig(), before, after, {0, 0});
    EXPECT_LT(exact, 5) << scene;
    for (const cv::Point2d& error_px :
         {cv::Point2d(1, 0), cv::Point2d(-1, 0), cv::Point2d(0, 1), cv::Point2d(0, -1)})
      EXPECT_GT(photometricError(street.rig(), before, after, error_px), 1.3 * exact)
          << scene << " " << index << ", " << error_px;
  }
}

TEST(Street, MisalignedRowsAreWhereTheySayTheyAre) {
  StreetParams params = smallStreet("misaligned");
  params.width = 800;
  params.height = 240;
  const Street street(params, plain("misaligned"));
  const StreetFrame frame = street.render(10);
  double largest = 0;
  for (const double x : {0.0, 799.0})
    for (const double y : {0.0, 239.0})
      largest = std::max(largest, std::abs(street.rightRowOffset(x, y)));
  EXPECT_NEAR(largest, 1.5, 0.02);
  EXPECT_EQ(Street(smallStreet("street")).rightRowOffset(0, 100), 0);

  // The aligned scene is the same except for the rows.
  simulation::Scene aligned = plain("misaligned");
  aligned.sensor.row_offset_px = 0;
  const StreetFrame reference = Street(params, aligned).render(10);
  EXPECT_TRUE(same(frame.left, reference.left));
  EXPECT_TRUE(same(frame.disparity_px, reference.disparity_px));

  // The right image is the aligned one with shifted rows.
  double moved = 0, kept = 0;
  int count = 0;
  for (int y = 4; y < 236; ++y)
    for (int x = 0; x < 800; ++x) {
      const double offset = street.rightRowOffset(x, y);
      if (std::abs(offset) < 0.3) continue;
      ++count;
      moved += std::abs(bilinear(frame.right, x, y + offset) - reference.right(y, x));
      kept += std::abs(frame.right(y, x) - reference.right(y, x));
    }
  EXPECT_GT(count, 10000);
  EXPECT_LT(moved, 0.6 * kept);
}

TEST(Street, TruthOfConsecutiveFramesAgrees) {
  for (const char* scene :
       {"street", "turn", "fast_rotation", "leader", "drone", "robot", "handheld"}) {
    const Street street(smallStreet(scene));
    const StereoRig& rig = street.rig();
    const StreetFrame before = street.render(50), after = street.render(51);
    const double dt = after.stamp_s - before.stamp_s;
    std::map<int, Vector3d> velocity;
    for (const StreetMover& mover : after.movers) velocity[mover.id] = mover.velocity_mps;
    int compared = 0, agree = 0;
    for (int y = 3; y < rig.size.height - 3; ++y) {
      for (int x = 3; x < rig.size.width - 3; ++x) {
        const float d = after.disparity_px(y, x);
        if (d == 0 || jumpAround(after.disparity_px, x, y, 1) > 0.5f) continue;
        const int id = after.moving_id(y, x);
        Vector3d point = after.T_world_cam * rig.pointFromDisparity(x, y, d);
        if (id != 0) point -= dt * velocity.at(id);
        const Vector3d omega =
            rig.disparityFromPoint(before.T_world_cam.inverse(Eigen::Isometry) * point);
        const cv::Point at(static_cast<int>(std::lround(omega.x())),
                           static_cast<int>(std::lround(omega.y())));
        if (!cv::Rect(2, 2, rig.size.width - 4, rig.size.height - 4).contains(at)) continue;
        if (omega.z() <= 0 || jumpAround(before.disparity_px, at.x, at.y, 2) > 1) continue;
        ++compared;
        agree += std::abs(before.disparity_px(at) - omega.z()) < 0.4;
      }
    }
    EXPECT_GT(compared, 12000) << scene;
    EXPECT_GT(agree, 0.97 * compared) << scene;  // the rest was occluded before
  }
}

TEST(Street, MoversAreWhereTheirRecordsSay) {
  int seen = 0;
  for (const char* scene : {"street", "leader", "standstill", "robot"}) {
    const Street street(smallStreet(scene));
    const StereoRig& rig = street.rig();
    for (const int index : {0, 40, 75}) {
      const StreetFrame frame = street.render(index);
      std::map<int, cv::Rect> boxes;
      std::map<int, double> outside;
      std::map<int, const StreetMover*> records;
      for (const StreetMover& mover : frame.movers) records[mover.id] = &mover;
      for (int y = 0; y < rig.size.height; ++y)
        for (int x = 0; x < rig.size.width; ++x) {
          const int id = frame.moving_id(y, x);
          if (id == 0) continue;
          boxes[id] |= cv::Rect(x, y, 1, 1);
          ASSERT_TRUE(records.count(id)) << "mover " << id << " has pixels but no record";
          const StreetMover& mover = *records[id];
          const Vector3d point = rig.pointFromDisparity(x, y, frame.disparity_px(y, x));
          ASSERT_GT(point.z(), mover.distance_m - 1e-3);
          // Mirrors, swinging legs and wheels extend slightly beyond the box.
          const Vector3d over = (point - mover.centre_m).cwiseAbs() - 0.5 * mover.extent_m;
          outside[id] = std::max(outside[id], over.maxCoeff());
        }
      ASSERT_EQ(boxes.size(), frame.movers.size());
      for (const StreetMover& mover : frame.movers) {
        ++seen;
        EXPECT_EQ(mover.box_px, boxes[mover.id]) << scene << " " << index << " " << mover.id;
        EXPECT_LT(outside[mover.id], 0.45) << mover.kind;
        EXPECT_GT(mover.velocity_mps.norm(), Street::kMovingSpeed_mps);
        EXPECT_GE(mover.occluded, 0);
        EXPECT_LE(mover.occluded, 1);
        EXPECT_GE(mover.truncated, 0);
        EXPECT_LE(mover.truncated, 1);
      }
    }
  }
  EXPECT_GT(seen, 20);
}

TEST(Street, FramesDependOnTheirIndexAlone) {
  const Street street(smallStreet("street"));
  const StreetFrame first = street.render(30);
  street.render(31);
  EXPECT_TRUE(same(first, street.render(30)));
  const int threads = cv::getNumThreads();
  for (const int count : {1, 3, 7}) {
    cv::setNumThreads(count);
    EXPECT_TRUE(same(first, street.render(30))) << count << " threads";
  }
  cv::setNumThreads(threads);
  EXPECT_TRUE(same(first, Street(smallStreet("street")).render(30))) << "a second street";
  StreetParams longer = smallStreet("street");
  longer.frames = 300;
  EXPECT_EQ(first.T_world_cam.matrix(), Street(longer).render(30).T_world_cam.matrix());
  StreetParams other = smallStreet("street");
  other.seed = 2;
  EXPECT_FALSE(same(first.left, Street(other).render(30).left));
}

TEST(Street, CameraMovesAsItsSceneSays) {
  // Distance of the vehicle, because the camera above it pitches.
  const auto travelled = [](const Street& street, int from, int to) {
    const Eigen::Isometry3d T_cam_vehicle = street.cameraMount().inverse();
    return ((street.poseOf(to) * T_cam_vehicle).translation() -
            (street.poseOf(from) * T_cam_vehicle).translation())
        .norm();
  };
  const auto turned = [](const Street& street, int from, int to) {
    return Eigen::AngleAxisd(street.poseOf(from).linear().transpose() * street.poseOf(to).linear())
               .angle() *
           180 / 3.14159265;
  };
  const Street standstill(smallStreet("standstill"));
  EXPECT_EQ(travelled(standstill, 0, 99), 0);
  EXPECT_EQ(standstill.poseOf(0).translation(), standstill.poseOf(99).translation());
  EXPECT_EQ(turned(standstill, 0, 99), 0);
  const Street rotation(smallStreet("rotation"));
  EXPECT_LT((rotation.poseOf(0).translation() - rotation.poseOf(99).translation()).norm(), 1e-9);
  EXPECT_GT(turned(rotation, 0, 10), 5);
  double fastest = 0;
  const Street fast(smallStreet("fast_rotation"));
  for (int i = 0; i < 60; ++i) fastest = std::max(fastest, turned(fast, i, i + 1));
  EXPECT_NEAR(fastest, 2.0, 0.1);  // 20 deg/s at 10 Hz
  EXPECT_GT(turned(Street(smallStreet("turn")), 0, 80), 80);
  double hardest = 0;
  const Street brake(smallStreet("brake"));
  for (int i = 0; i + 2 < 60; ++i)
    hardest =
        std::max(hardest, (travelled(brake, i, i + 1) - travelled(brake, i + 1, i + 2)) * 100);
  EXPECT_NEAR(hardest, 8, 0.8);
}

TEST(Street, DroppedAndRepeatedFrames) {
  const Street dropped(smallStreet("dropped"));
  int gaps = 0;
  for (int i = 0; i < 40; ++i) {
    const double step = dropped.stampOf(i + 1) - dropped.stampOf(i);
    gaps += step > 0.15;
    ASSERT_LT(step, 0.21);
  }
  EXPECT_EQ(gaps, 10);
  const Street repeated(smallStreet("duplicated"));
  EXPECT_TRUE(same(repeated.render(3).left, repeated.render(4).left));
  EXPECT_FALSE(same(repeated.render(4).left, repeated.render(5).left));
  EXPECT_NEAR(repeated.stampOf(4) - repeated.stampOf(3), 0.1, 1e-9);
}

// Mean share of moving pixels in the left image.
double movingShare(const std::string& scene) {
  const Street street(smallStreet(scene));
  double sum = 0;
  int frames = 0;
  for (int i = 0; i < street.frames(); i += 9, ++frames) {
    const StreetFrame frame = street.render(i);
    sum += cv::countNonZero(frame.moving_id) / static_cast<double>(frame.moving_id.total());
  }
  return sum / frames;
}

TEST(Street, MoversCoverWhatTheirSceneSays) {
  EXPECT_NEAR(movingShare("crowded"), 0.40, 0.07);
  EXPECT_NEAR(movingShare("near_half_moves"), 0.5, 0.08);
  EXPECT_EQ(movingShare("static"), 0);
  EXPECT_GT(movingShare("street"), 0.01);
}

TEST(Street, RainDiffersBetweenTheCameras) {
  simulation::Scene rain = plain("rain"), dry = rain;
  dry.sensor.rain = 0;
  const StreetFrame wet = Street(smallStreet("rain"), rain).render(3);
  const StreetFrame clear = Street(smallStreet("rain"), dry).render(3);
  const cv::Mat on_left = wet.left != clear.left, on_right = wet.right != clear.right;
  EXPECT_GT(cv::countNonZero(on_left), 200);
  EXPECT_LT(cv::countNonZero(on_left & on_right), cv::countNonZero(on_left) / 4);
}

TEST(Street, LongExposuresBlur) {
  simulation::Scene sharp = plain("blur");
  sharp.sensor.exposure_time_s = 0;
  const StreetFrame still = Street(smallStreet("blur"), sharp).render(40);
  const StreetFrame blurred = Street(smallStreet("blur"), plain("blur")).render(40);
  const auto sharpness = [](const cv::Mat1b& image) {
    cv::Mat1f gradient;
    cv::Sobel(image, gradient, CV_32F, 1, 0);
    return cv::mean(cv::abs(gradient))[0];
  };
  EXPECT_LT(sharpness(blurred.left), 0.85 * sharpness(still.left));
  EXPECT_TRUE(same(blurred.disparity_px, still.disparity_px));
}

TEST(Street, EverySceneRenders) {
  for (const simulation::Scene& info : simulation::scenes()) {
    StreetParams params = smallStreet(info.name);
    params.width = 160;
    params.height = 48;
    const StreetFrame frame = Street(params).render(5);
    EXPECT_EQ(frame.left.size(), cv::Size(160, 48)) << info.name;
    EXPECT_FALSE(info.summary.empty());
    cv::Scalar mean, deviation;
    cv::meanStdDev(frame.left, mean, deviation);
    EXPECT_GT(deviation[0], 5) << info.name;
    EXPECT_GT(mean[0], 5) << info.name;
  }
}

TEST(Street, RefusesWhatItDoesNotKnow) {
  const auto messageOf = [](const StreetParams& params) -> std::string {
    try {
      Street street(params);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  StreetParams params;
  params.scene = "moon";
  EXPECT_NE(messageOf(params).find("moon"), std::string::npos);
  EXPECT_NE(messageOf(params).find("fast_rotation"), std::string::npos);
  params = StreetParams();
  params.width = 3;
  EXPECT_NE(messageOf(params).find("width = 3"), std::string::npos);
  EXPECT_THROW(Street(smallStreet("street")).render(100), std::invalid_argument);
  EXPECT_THROW(Street(smallStreet("street")).render(-1), std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
