/// Stamps of frames, and the check whether a frame continues the sequence of the previous one.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>

#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// Time of a frame since any epoch. Exact; a double of seconds since 1970 is not.
using Stamp = std::chrono::nanoseconds;

/// [s], rounded to a double: to 0.2 us for times since 1970.
inline double toSeconds(Stamp time) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(time);
  return static_cast<double>(whole.count()) + 1e-9 * static_cast<double>((time - whole).count());
}
/// @param time_s  finite, within 292 years of the epoch; this is not checked.
inline Stamp stampFromSeconds(double time_s) {
  const double whole_s = std::floor(time_s);
  return std::chrono::seconds(static_cast<int64_t>(whole_s)) +
         std::chrono::nanoseconds(std::llround(1e9 * (time_s - whole_s)));
}

/// Decides whether a frame continues the previous one, so that it may use the state of the past.
class SequenceGuard {
 public:
  enum class Verdict {
    kContinues,
    kFirst,
    kDuplicate,  ///< the same stamp again
    kLate,       ///< up to kLargestDelay_s older than the previous frame, as if frames were swapped
    kBackward,   ///< time went back farther: another pass of a bag, or another source
    kBroken,     ///< a gap, or another calibration or image size
  };
  struct Result {
    Verdict verdict;
    std::string reason;  ///< one sentence for logs; empty if kContinues

    /// Whether the frame must be ignored: it is no step of the sequence.
    bool isIgnored() const { return verdict == Verdict::kDuplicate || verdict == Verdict::kLate; }
    /// Whether the state of past frames must be discarded. The caller should log `reason` then.
    bool startsAnew() const { return verdict == Verdict::kBackward || verdict == Verdict::kBroken; }
  };

  static constexpr double kLargestDelay_s = 0.5;

  /// @param max_gap_s  a longer gap between two frames breaks the sequence.
  explicit SequenceGuard(double max_gap_s) : max_gap_s_(max_gap_s) {}

  /// Compares a frame with the last one. It then becomes the last one, unless it is ignored.
  Result next(Stamp stamp, const StereoRig& rig) {
    const Result result = compareWithLast(stamp, rig);
    if (!result.isIgnored()) last_ = Frame{stamp, rig};
    return result;
  }

  /// The next frame is the first one again.
  void forget() { last_.reset(); }

 private:
  struct Frame {
    Stamp stamp;
    StereoRig rig;
  };

  Result compareWithLast(Stamp stamp, const StereoRig& rig) const {
    if (!last_) return {Verdict::kFirst, "first frame"};
    const double gap_s = toSeconds(stamp - last_->stamp);
    std::ostringstream reason;
    if (gap_s == 0)
      return {Verdict::kDuplicate,
              "the frame has the stamp of the one before, and is ignored: its publisher must give "
              "each frame a stamp of its own"};
    if (gap_s < 0 && gap_s >= -kLargestDelay_s) {
      reason << "the pair is " << -gap_s
             << " s older than the one before, and is ignored: its publisher must send pairs in "
                "the order of their stamps";
      return {Verdict::kLate, reason.str()};
    }
    if (gap_s < 0) {
      reason << "stamps went back by " << -gap_s << " s: starting anew";
      return {Verdict::kBackward, reason.str()};
    }
    if (rig != last_->rig) {
      reason << (rig.size != last_->rig.size ? "image size" : "calibration")
             << " changed: starting anew";
      return {Verdict::kBroken, reason.str()};
    }
    if (gap_s > max_gap_s_) {
      reason << "no frame for " << gap_s << " s, more than max_gap = " << max_gap_s_
             << " s: starting anew";
      return {Verdict::kBroken, reason.str()};
    }
    return {Verdict::kContinues, ""};
  }

  double max_gap_s_;
  std::optional<Frame> last_;
};

}  // namespace predictive_stereo
