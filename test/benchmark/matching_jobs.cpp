#include "benchmark/matching_jobs.h"

#include <algorithm>
#include <stdexcept>

#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/post_filter.h"

namespace predictive_stereo {

std::vector<MatchingJob> matchingJobs(const Sequence& sequence, const DisparityParams& params,
                                      int frames) {
  const DisparityRange& range = params.matcher.range;
  EgoMotion ego_motion({});
  CoarseMatcher coarse_matcher(params.matcher);
  RowAligner aligner(params.row_alignment);
  Predictor predictor(range, params.prediction);
  SearchRangeBuilder builder(range, params.search);
  StereoMatcher matcher(params.matcher);
  DisparityState state;
  Prediction prediction;
  Match match;
  cv::Mat1f coarse_px, measured_px;
  std::vector<MatchingJob> jobs;
  for (int i = 0; i < std::min(frames, sequence.frames()); ++i) {
    const SequenceFrame frame = sequence.frame(i);
    MatchingJob job{frame.left, frame.right, {}, frame.truth_px, {}, {}, {}};
    const EgoMotionEstimate ego = ego_motion.estimate(frame.left, frame.right, sequence.rig());
    job.motion = ego.motion;
    coarse_matcher.match(frame.left, frame.right, coarse_px);
    const RowOffsetModel alignment = aligner.estimate(frame.left, frame.right, coarse_px, range);
    alignRightImage(frame.right, alignment, 0, job.aligned_right);
    if (ego.status == EgoMotionStatus::kTracked)
      predictor.predict(state, sequence.rig(), ego.motion, prediction);
    else
      predictor.predictNothing(frame.left.size(), prediction);
    builder.build(prediction, coarse_px, job.ranges);
    job.previous = {state.disparity_px.clone(), state.variance_px2.clone(),
                    state.missed_frames.clone()};
    matcher.match(job.left, job.aligned_right, job.ranges, match);
    filterBySupport(range, params.min_support, match.disparity_px, measured_px);
    correct(prediction, measured_px, range, params.correction, state);
    if (i >= kFramesBefore && ego.status == EgoMotionStatus::kTracked) jobs.push_back(job);
    job.ranges = {};
  }
  if (jobs.empty()) throw std::runtime_error("the camera's motion could not be followed");
  return jobs;
}

}  // namespace predictive_stereo
