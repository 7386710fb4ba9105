#include "mapping/core/vectors.hpp"

#include <cstdint>

#include <hwy/highway.h>

namespace cloister {

void limit_vector_bits(int bits) {
  constexpr std::int64_t k512 = HWY_AVX3 | HWY_AVX3_DL;
  constexpr std::int64_t k256 = HWY_AVX2 | HWY_SVE_256;
  constexpr std::int64_t k128 = HWY_SSE4 | HWY_SSSE3 | HWY_NEON | HWY_SVE | HWY_SVE2 | HWY_SVE2_128;
  std::int64_t disabled = 0;
  if (bits > 0 && bits < 512) disabled |= k512;
  if (bits > 0 && bits < 256) disabled |= k256;
  if (bits > 0 && bits < 128) disabled |= k128;
  hwy::DisableTargets(disabled);
  // What was chosen before is chosen again at the next call.
  hwy::GetChosenTarget().DeInit();
}

}  // namespace cloister
