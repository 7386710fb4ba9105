#include "bench/simulate/ray_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <embree3/rtcore.h>

namespace cloister {

namespace {

constexpr int kPacket = 16;

/// Closest point of triangle (a, b, c) to p, by the region of the barycentric plane that p projects
/// into (C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
Eigen::Vector3f closest_on_triangle(const Eigen::Vector3f& p, const Eigen::Vector3f& a,
                                    const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  const Eigen::Vector3f ab = b - a;
  const Eigen::Vector3f ac = c - a;
  const float d1 = ab.dot(p - a);
  const float d2 = ac.dot(p - a);
  if (d1 <= 0.0F && d2 <= 0.0F) return a;
  const float d3 = ab.dot(p - b);
  const float d4 = ac.dot(p - b);
  if (d3 >= 0.0F && d4 <= d3) return b;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F) return a + ab * (d1 / (d1 - d3));
  const float d5 = ab.dot(p - c);
  const float d6 = ac.dot(p - c);
  if (d6 >= 0.0F && d5 <= d6) return c;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F) return a + ac * (d2 / (d2 - d6));
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0.0F && d4 >= d3 && d5 >= d6) {
    return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  }
  const float sum = va + vb + vc;
  if (!(sum > 0.0F)) return a;  // a triangle without area: its edges were handled above
  return a + ab * (vb / sum) + ac * (vc / sum);
}

/// Counts the crossings of an upward ray; Embree wants its own context first, ours follows it.
struct CrossingContext {
  RTCIntersectContext embree;
  int winding;
};

void count_crossing(const RTCFilterFunctionNArguments* arguments) {
  auto* context = reinterpret_cast<CrossingContext*>(arguments->context);
  for (unsigned k = 0; k < arguments->N; ++k) {
    if (arguments->valid[k] == 0) continue;
    const unsigned N = arguments->N;
    const float along = RTCHitN_Ng_x(arguments->hit, N, k) * RTCRayN_dir_x(arguments->ray, N, k) +
                        RTCHitN_Ng_y(arguments->hit, N, k) * RTCRayN_dir_y(arguments->ray, N, k) +
                        RTCHitN_Ng_z(arguments->hit, N, k) * RTCRayN_dir_z(arguments->ray, N, k);
    context->winding +=
        along > 0.0F ? 1 : -1;  // the ray points up: leaving a solid counts up, entering down
    arguments->valid[k] = 0;    // go on past it
  }
}

struct DistanceQuery {
  const TriangleMesh* mesh;
  Eigen::Vector3f point;
  float best;
};

bool shrink_to_triangle(RTCPointQueryFunctionArguments* arguments) {
  auto* query = static_cast<DistanceQuery*>(arguments->userPtr);
  const TriangleMesh& mesh = *query->mesh;
  const std::size_t id = arguments->primID;
  const Eigen::Vector3f nearest =
      closest_on_triangle(query->point, mesh.corner(id, 0), mesh.corner(id, 1), mesh.corner(id, 2));
  const float distance = (nearest - query->point).norm();
  if (distance >= query->best) return false;
  query->best = distance;
  arguments->query->radius = distance;
  return true;
}

}  // namespace

struct RayScene::Embree {
  const TriangleMesh* mesh = nullptr;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  Embree() = default;
  Embree(const Embree&) = delete;
  Embree& operator=(const Embree&) = delete;
  ~Embree() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

RayScene::RayScene(std::unique_ptr<Embree> embree) : embree_(std::move(embree)) {}
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;
RayScene::~RayScene() = default;

Result<RayScene> RayScene::build(const TriangleMesh& mesh) {
  if (mesh.triangles.empty())
    return fail(ErrorKind::kInput, "the mesh has no triangles: give one with faces");
  auto embree = std::make_unique<Embree>();
  embree->mesh = &mesh;
  embree->device = rtcNewDevice(nullptr);
  if (embree->device == nullptr)
    return fail(ErrorKind::kResource, "Embree did not start: check its installation");
  embree->scene = rtcNewScene(embree->device);
  rtcSetSceneFlags(
      embree->scene,
      static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
  RTCGeometry geometry = rtcNewGeometry(embree->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  // Copies: Embree reads 16 bytes per vertex, so the last one of a shared buffer would be read past
  // its end.
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           sizeof(Eigen::Vector3f), mesh.vertices.size());
  void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(std::uint32_t), mesh.triangles.size());
  if (vertices == nullptr || triangles == nullptr) {
    rtcReleaseGeometry(geometry);
    return fail(ErrorKind::kResource, "no memory for a mesh of " +
                                          std::to_string(mesh.triangles.size()) +
                                          " triangles: use a smaller one");
  }
  std::copy(mesh.vertices.begin(), mesh.vertices.end(), static_cast<Eigen::Vector3f*>(vertices));
  std::copy(mesh.triangles.begin(), mesh.triangles.end(),
            static_cast<std::array<std::uint32_t, 3>*>(triangles));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(embree->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(embree->scene);
  if (rtcGetDeviceError(embree->device) != RTC_ERROR_NONE) {
    return fail(ErrorKind::kResource, "Embree could not index the mesh: use a smaller one");
  }
  return RayScene(std::move(embree));
}

void RayScene::cast(const Eigen::Vector3f& origin, std::span<const Eigen::Vector3f> directions,
                    float max_distance_m, std::span<RayHit> hits) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  RTCRayHit16 packet;
  alignas(64) std::array<int, kPacket> valid;
  for (std::size_t first = 0; first < directions.size(); first += kPacket) {
    const std::size_t count = std::min<std::size_t>(kPacket, directions.size() - first);
    for (std::size_t k = 0; k < kPacket; ++k) {
      const Eigen::Vector3f& direction = directions[first + std::min(k, count - 1)];
      valid[k] = k < count ? -1 : 0;
      packet.ray.org_x[k] = origin.x();
      packet.ray.org_y[k] = origin.y();
      packet.ray.org_z[k] = origin.z();
      packet.ray.dir_x[k] = direction.x();
      packet.ray.dir_y[k] = direction.y();
      packet.ray.dir_z[k] = direction.z();
      packet.ray.tnear[k] = 0.0F;
      packet.ray.tfar[k] = max_distance_m;
      packet.ray.time[k] = 0.0F;
      packet.ray.mask[k] = ~0U;
      packet.ray.flags[k] = 0;
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid.data(), embree_->scene, &context, &packet);
    for (std::size_t k = 0; k < count; ++k) {
      RayHit& hit = hits[first + k];
      if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) {
        hit = RayHit{};
        continue;
      }
      const Eigen::Vector3f normal(packet.hit.Ng_x[k], packet.hit.Ng_y[k], packet.hit.Ng_z[k]);
      hit.triangle = packet.hit.primID[k];
      hit.distance_m = packet.ray.tfar[k];
      hit.cos_incidence = std::abs(normal.dot(directions[first + k])) / normal.norm();
    }
  }
}

bool RayScene::line_of_sight(const Eigen::Vector3f& a, const Eigen::Vector3f& b) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  const Eigen::Vector3f d = b - a;
  RTCRay ray{a.x(), a.y(), a.z(), 0.0F, d.x(), d.y(), d.z(), 0.0F, 1.0F, ~0U, 0, 0};
  rtcOccluded1(embree_->scene, &context, &ray);
  return ray.tfar >= 0.0F;  // Embree reports a blocked ray by tfar = -inf
}

float RayScene::distance(const Eigen::Vector3f& point, float limit_m) const {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  RTCPointQuery query{point.x(), point.y(), point.z(), 0.0F, limit_m};
  DistanceQuery state{embree_->mesh, point, limit_m};
  rtcPointQuery(embree_->scene, &query, &context, shrink_to_triangle, &state);
  return state.best;
}

bool RayScene::is_inside(const Eigen::Vector3f& point) const {
  constexpr std::array<std::array<float, 2>, 3> kTilts = {
      {{0.0131F, 0.0071F}, {-0.0093F, 0.0117F}, {0.0037F, -0.0149F}}};
  int votes = 0;
  for (const auto& tilt : kTilts) {
    CrossingContext context{};
    rtcInitIntersectContext(&context.embree);
    context.embree.filter = count_crossing;
    RTCRay ray{point.x(), point.y(), point.z(),
               0.0F,      tilt[0],   tilt[1],
               1.0F,      0.0F,      std::numeric_limits<float>::infinity(),
               ~0U,       0,         0};
    rtcOccluded1(embree_->scene, &context.embree, &ray);
    votes += context.winding > 0 ? 1 : 0;
  }
  return votes >= 2;
}

}  // namespace cloister
