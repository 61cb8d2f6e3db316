/// How well a method knows which of its disparities are wrong.
#pragma once

#include <vector>

namespace predictive_stereo {

/// Sparsification: pixels are left out in the order of their doubt, the most doubtful first. The
/// mean error of the rest falls as fast as that of an oracle, which knows the errors, if the doubt
/// is right. The area between both curves, over the share that is left out, is the sparsification
/// error (AUSE; Ilg et al., "Uncertainty estimates and multi-hypotheses networks for optical flow",
/// ECCV 2018). Without a limit of errors, large ones decide.
class Sparsification {
 public:
  /// @param doubt  of any scale; the larger, the less certain.
  void add(double error_px, double doubt);
  Sparsification& operator+=(const Sparsification& other);

  bool empty() const { return pixels_.empty(); }
  /// Of the absolute errors. 0 without pixels, and so are the following.
  double meanError_px() const;
  /// Area between the curves of doubt and oracle. Pixels of equal doubt have their mean error.
  double ause_px() const;
  /// The same for a doubt that knows nothing.
  double auseOfNothing_px() const;

 private:
  struct Pixel {
    float doubt, error_px;
  };
  std::vector<Pixel> pixels_;
};

}  // namespace predictive_stereo
