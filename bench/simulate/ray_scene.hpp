#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include <Eigen/Core>

#include "bench/simulate/triangle_mesh.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// Where a ray met the mesh first.
struct RayHit {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::uint32_t triangle = kNone;
  float distance_m = 0.0F;
  float cos_incidence = 0.0F;  ///< between the ray and the triangle's normal, 0 = grazing
};

/// Rays, distances and the inside of a triangle mesh, answered by Embree. The mesh must outlive the
/// scene. Threads: all const members may be called from several threads at once.
class RayScene {
 public:
  /// Builds the search tree. Errors: kInput for a mesh without triangles, kResource when Embree
  /// cannot start.
  [[nodiscard]] static Result<RayScene> build(const TriangleMesh& mesh);

  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;
  ~RayScene();

  /// Casts rays of one common origin. @param directions unit length; @param hits as many as
  /// directions
  void cast(const Eigen::Vector3f& origin, std::span<const Eigen::Vector3f> directions,
            float max_distance_m, std::span<RayHit> hits) const;

  /// True when nothing lies on the segment between the two points.
  [[nodiscard]] bool line_of_sight(const Eigen::Vector3f& a, const Eigen::Vector3f& b) const;

  /// Distance to the nearest point of the mesh, at most `limit_m` (returned when nothing is
  /// closer).
  [[nodiscard]] float distance(const Eigen::Vector3f& point, float limit_m) const;

  /// True inside a closed part of the mesh, or below an open sheet that faces up: the signed
  /// crossings of a nearly vertical ray are counted, three times with different tilts, and the
  /// majority decides.
  [[nodiscard]] bool is_inside(const Eigen::Vector3f& point) const;

 private:
  struct Embree;
  explicit RayScene(std::unique_ptr<Embree> embree);
  std::unique_ptr<Embree> embree_;
};

}  // namespace cloister
