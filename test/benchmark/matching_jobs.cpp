#include "benchmark/matching_jobs.h"

#include <algorithm>
#include <stdexcept>

#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

std::vector<MatchingJob> matchingJobs(const Sequence& sequence, const DisparityParams& params,
                                      int frames) {
  PipelineParams pipeline_params;
  pipeline_params.disparity = params;
  Pipeline pipeline(pipeline_params);
  PipelineOutput output;
  std::vector<MatchingJob> jobs;
  for (int i = 0; i < std::min(frames, sequence.frames()); ++i) {
    const SequenceFrame frame = sequence.frame(i);
    const DisparityState& past = pipeline.disparity().past().filters();
    MatchingJob job{frame.left, frame.right, {}, frame.truth_px, {}, {}, {}};
    job.previous = {past.disparity_px.clone(), past.variance_px2.clone(),
                    past.missed_frames.clone()};
    pipeline.process(stereoFrame(sequence, i, frame), output);
    if (i < kFramesBefore || !output.disparity.predicted) continue;
    job.motion = output.ego_motion.motion;
    job.aligned_right = pipeline.disparity().alignedRight().clone();
    job.ranges = {pipeline.disparity().ranges().first.clone(),
                  pipeline.disparity().ranges().last.clone()};
    jobs.push_back(job);
  }
  if (jobs.empty()) throw std::runtime_error("the camera's motion could not be followed");
  return jobs;
}

}  // namespace predictive_stereo
