#include "matching/row_visits.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace predictive_stereo {
namespace {

/// State of the rows, checked at each visit.
class Rows {
 public:
  Rows(int height, int strips)
      : height_(height),
        strips_(strips),
        across_(height),
        finished_(height),
        down_(2 * height * strips),
        rows_of_slots_(kChunkSlots) {}

  void across(int y) { EXPECT_EQ(across_[y]++, 0); }
  void takeSlot(const RowVisit& visit) { rows_of_slots_[visit.slot] = visit.y; }
  void requireSlot(const RowVisit& visit) {
    EXPECT_EQ(rows_of_slots_[visit.slot], visit.y) << "another row took its slot";
  }
  void down(const RowVisit& visit, int strip) {
    const int previous = visit.upward ? visit.y + 1 : visit.y - 1;
    EXPECT_EQ(across_[visit.y], 1);
    EXPECT_EQ(finished_[visit.y], 0);
    if (previous >= 0 && previous < height_) {
      EXPECT_EQ(visits(previous, visit.upward, strip), 1) << "the row before is missing";
    }
    EXPECT_EQ(visits(visit.y, !visit.upward, strip), visit.is_first ? 0 : 1);
    EXPECT_EQ(visits(visit.y, visit.upward, strip)++, 0);
  }
  void finish(int y) {
    for (int strip = 0; strip < strips_; ++strip)
      for (const bool upward : {false, true}) EXPECT_EQ(visits(y, upward, strip), 1);
    EXPECT_EQ(finished_[y]++, 0);
  }
  bool all_finished() const {
    for (const auto& times : finished_)
      if (times != 1) return false;
    return true;
  }

 private:
  std::atomic<int>& visits(int y, bool upward, int strip) {
    return down_[(y * strips_ + strip) * 2 + upward];
  }

  const int height_, strips_;
  std::vector<std::atomic<int>> across_, finished_, down_, rows_of_slots_;
};

TEST(RowVisits, ByStripsComeInOrder) {
  for (const int height : {1, 2, 33, 64, 65, 200})
    for (const int middle : {0, height / 3, height / 2, height})
      for (const int strips : {1, 3, 8}) {
        SCOPED_TRACE(testing::Message() << height << " rows, middle " << middle);
        Rows rows(height, strips);
        const auto across = [&](const RowVisit& visit) {
          rows.across(visit.y);
          rows.takeSlot(visit);
        };
        const auto down = [&](const RowVisit& visit, int strip) {
          rows.down(visit, strip);
          if (visit.is_first) rows.requireSlot(visit);
        };
        const auto finish = [&](const RowVisit& visit) { rows.finish(visit.y); };
        visitRowsByStrips(height, middle, strips, across, down, finish);
        EXPECT_TRUE(rows.all_finished());
      }
}

TEST(RowVisits, ByPassesComeInOrder) {
  for (const int height : {1, 2, 33, 200})
    for (const int middle : {0, height / 3, height}) {
      Rows rows(height, 1);
      for (int y = 0; y < height; ++y) rows.across(y);
      visitRowsTwice(height, middle, [&](const RowVisit& visit) {
        rows.down(visit, 0);
        if (!visit.is_first) rows.finish(visit.y);
      });
      EXPECT_TRUE(rows.all_finished());
    }
}

}  // namespace
}  // namespace predictive_stereo
