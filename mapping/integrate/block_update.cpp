#include "mapping/integrate/block_update.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/integrate/block_update.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "mapping/integrate/block_update-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace cloister::HWY_NAMESPACE {

std::size_t apply_marks_vectors(const Evidence& evidence, const ScanMarks::Marked& marked,
                                VoxelPools& pools, Volume& volume) {
  Chunk* chunk = nullptr;
  std::uint32_t* place = volume.make_place(pools, marked.coord, &chunk);
  if (place == nullptr) return kBlockVoxels;
  BlockBits free = marked.crossed;
  for (int z = 0; z < kBlockEdge; ++z) free.word[z] &= ~marked.hit.word[z];
  return apply_to_place(evidence, free, free, marked.hit, pools, volume, *chunk, *place);
}

}  // namespace cloister::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cloister {

HWY_EXPORT(apply_marks_vectors);

std::size_t apply_marks(const Evidence& evidence, const ScanMarks::Marked& marked,
                        VoxelPools& pools, Volume& volume) {
  return HWY_DYNAMIC_DISPATCH(apply_marks_vectors)(evidence, marked, pools, volume);
}

}  // namespace cloister
#endif
