#include "filtering/connection_rows.h"

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "filtering/connection_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Processes pixels from x on in whole vectors; returns the first pixel that is left over.
template <class D>
HWY_INLINE int connectPixels(D d, const float* pixels, const float* neighbours, int count,
                             float smallest_valid, int x, uint8_t* connected) {
  const hn::RebindToSigned<D> di;
  const hn::Rebind<uint8_t, D> d8;
  const auto smallest = hn::Set(d, smallest_valid), one = hn::Set(d, 1.0f);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (; x + lanes <= count; x += lanes) {
    const auto a = hn::LoadU(d, pixels + x), b = hn::LoadU(d, neighbours + x);
    const auto same = hn::And(hn::Ge(hn::Min(a, b), smallest), hn::Le(hn::Abs(hn::Sub(a, b)), one));
    const auto flags = hn::IfThenElseZero(hn::RebindMask(di, same), hn::Set(di, 1));
    hn::StoreU(hn::DemoteTo(d8, flags), d8, connected + x);
  }
  return x;
}

void connectionsOfRow(const float* pixels, const float* neighbours, int count, float smallest_valid,
                      uint8_t* connected) {
  const int x = connectPixels(hn::ScalableTag<float>(), pixels, neighbours, count, smallest_valid,
                              0, connected);
  connectPixels(hn::FixedTag<float, 1>(), pixels, neighbours, count, smallest_valid, x, connected);
}

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(connectionsOfRow);

void connectionsOfRow(const float* pixels, const float* neighbours, int count, float smallest_valid,
                      uint8_t* connected) {
  HWY_DYNAMIC_DISPATCH(connectionsOfRow)(pixels, neighbours, count, smallest_valid, connected);
}

}  // namespace predictive_stereo
#endif
