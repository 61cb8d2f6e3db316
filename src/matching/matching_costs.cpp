#include "matching/matching_costs.h"

#include <bitset>

namespace predictive_stereo {

CostTables::CostTables(int p2) {
  for (unsigned left = 0; left < 16; ++left)
    for (unsigned right = 0; right < 16; ++right) {
      distance[left][right] = static_cast<uint8_t>(std::bitset<4>(left ^ right).count());
      distance_and_p2[left][right] = static_cast<uint8_t>(distance[left][right] + p2);
    }
}

int nibbleCount(CensusForm form) { return form == CensusForm::kCentreSymmetric9x7 ? 8 : 6; }

}  // namespace predictive_stereo
