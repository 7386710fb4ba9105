// Maps one cloud with the installed library and asks what it left.
#include <cstdio>

#include "firmware_interface/files/g2o_file.hpp"
#include "mapping/integrate/scan_integrator.hpp"
#include "runtime/config_file.hpp"

int main() {
  const cloister::VoxelConfig config;
  cloister::VoxelStore store(/*num_blocks=*/1'000, /*num_chunks=*/100);
  cloister::VoxelPools pools(store);
  pools.take_all();
  cloister::Volume volume;
  cloister::ScanIntegrator integrator(config);

  // One return 5 m ahead of the origin.
  cloister::Scan scan;
  scan.kind = cloister::Scan::Kind::kCloud;
  scan.points_L = {{5.0F, 0.01F, 0.01F}};
  scan.poses = {{{0}, cloister::Pose::Identity()}};
  cloister::ScanBeams beams(scan.points_L.size());
  beams.assign(scan, cloister::Pose::Identity(), config);
  integrator.integrate(beams, Eigen::Vector3f::Zero(), pools, volume);

  const auto at = [&](float x_m) {
    return int{volume.at(store, {static_cast<int>(x_m / config.voxel_size_m), 0, 0})};
  };
  // The other two libraries have to link, with all that they need.
  const bool config_loads = cloister::load_config({}, {}).has_value();
  const bool bad_graph_loads =
      cloister::read_g2o("VERTEX_SE3:QUAT 0", "text", cloister::G2oOptions{}).has_value();
  // Surfaces are marked a little behind their returns.
  const float surface_m = 5.0F + static_cast<float>(config.return_depth_m);
  std::printf("return %d, on the way %d, behind %d\n", at(surface_m), at(2.5F), at(6.0F));
  return at(surface_m) > 0 && at(2.5F) < 0 && at(6.0F) == 0 && config_loads && !bad_graph_loads ? 0 : 1;
}
