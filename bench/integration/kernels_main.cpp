#include <benchmark/benchmark.h>

#include "bench/integration/cloister_map.hpp"
#include "bench/integration/room_scan.hpp"
#include "mapping/fuse/fuser.hpp"
#include "mapping/mesh/marching_cubes.hpp"
#include "mapping/overlap/voxel_overlap.hpp"

namespace cloister {
namespace {

constexpr std::int64_t kBudgetBytes = 512LL << 20;
// Scans after which a volume of one room does not change any more.
constexpr int kScansUntilFull = 20;

/// A room and an empty map. The argument chooses the room: 0 a small one, 1 a hall.
struct Kernel {
  explicit Kernel(std::int64_t which)
      : room(make_room_scan(which == 0 ? Eigen::Vector3d(8, 6, 2.8) : Eigen::Vector3d(80, 60, 12))),
        map(Config{}, room.scan.ranges_mm.size(), kBudgetBytes) {}

  void fill() {
    for (int i = 0; i < kScansUntilFull; ++i) map.integrate(room.scan, Pose::Identity());
  }

  RoomScan room;
  CloisterMap map;
};

/// Reports the time for each of `count` items of an iteration.
void set_time_each(benchmark::State& state, const char* name, double count) {
  state.counters[name] = benchmark::Counter(
      count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void place_scan(benchmark::State& state) {
  Kernel kernel(state.range(0));
  for (auto _ : state) kernel.map.place(kernel.room.scan, Pose::Identity());
  set_time_each(state, "per_pixel", static_cast<double>(kernel.room.scan.ranges_mm.size()));
}

void integrate_into_empty(benchmark::State& state) {
  Kernel kernel(state.range(0));
  kernel.map.place(kernel.room.scan, Pose::Identity());
  std::size_t blocks = 0;
  for (auto _ : state) {
    blocks = kernel.map.integrate_placed();
    state.PauseTiming();
    kernel.map.clear();
    state.ResumeTiming();
  }
  set_time_each(state, "per_voxel", static_cast<double>(blocks * kBlockVoxels));
}

void integrate_into_full(benchmark::State& state) {
  Kernel kernel(state.range(0));
  kernel.fill();
  std::size_t blocks = 0;
  for (auto _ : state) blocks = kernel.map.integrate_placed();
  set_time_each(state, "per_voxel", static_cast<double>(blocks * kBlockVoxels));
}

void fuse_blocks(benchmark::State& state) {
  Kernel kernel(state.range(0));
  kernel.fill();
  // On one grid blocks are added as they are; turned, every voxel is looked up.
  Pose T_from_into = Pose::Identity();
  if (state.range(1) != 0) T_from_into.rotate(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()));
  Volume into;
  for (auto _ : state) {
    const bool is_fused =
        fuse_volume(kernel.map.volume(), T_from_into, VoxelConfig{}, kernel.map.pools(), into);
    if (!is_fused) state.SkipWithError("the pools are too small");
    state.PauseTiming();
    into.clear(kernel.map.pools());
    state.ResumeTiming();
  }
  set_time_each(state, "per_block", static_cast<double>(kernel.map.volume().num_blocks()));
}

void overlap_voxels(benchmark::State& state) {
  Kernel kernel(state.range(0));
  kernel.fill();
  Pose T_b_a = Pose::Identity();
  if (state.range(1) != 0) T_b_a.rotate(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()));
  const Volume& volume = kernel.map.volume();
  VoxelOverlap overlap;
  for (auto _ : state) {
    overlap = voxel_overlap(kernel.map.store(), volume, volume, T_b_a, VoxelConfig{}.voxel_size_m);
    benchmark::DoNotOptimize(overlap);
  }
  set_time_each(state, "per_voxel", static_cast<double>(overlap.num_known_a));
}

void mesh_blocks(benchmark::State& state) {
  Kernel kernel(state.range(0));
  kernel.fill();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        extract_mesh(kernel.map.store(), kernel.map.volume(), VoxelConfig{}.voxel_size_m));
  }
  set_time_each(state, "per_block", static_cast<double>(kernel.map.volume().num_blocks()));
}

BENCHMARK(place_scan)->ArgName("hall")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(integrate_into_empty)->ArgName("hall")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(integrate_into_full)->ArgName("hall")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(fuse_blocks)
    ->ArgNames({"hall", "turned"})
    ->ArgsProduct({{0}, {0, 1}})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(overlap_voxels)
    ->ArgNames({"hall", "turned"})
    ->ArgsProduct({{0}, {0, 1}})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(mesh_blocks)->ArgName("hall")->Arg(0)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace cloister

BENCHMARK_MAIN();
