#include "bench/simulate/world.hpp"

#include <algorithm>

#include "bench/simulate/campus.hpp"
#include "bench/simulate/house.hpp"
#include "bench/simulate/large_rooms.hpp"
#include "bench/simulate/small_rooms.hpp"
#include "bench/simulate/three_storey.hpp"

namespace cloister {

bool World::is_solid(const Eigen::Vector3d& p_W) const {
  if (ground && ground->is_below(p_W)) return true;
  const Eigen::Vector3f p = p_W.cast<float>();
  return std::any_of(solids.begin(), solids.end(),
                     [&](const BoxSolid& solid) { return solid.contains(p_W); }) ||
         std::any_of(parts.begin(), parts.end(),
                     [&](const ConvexPart& part) { return part.contains(mesh, p); });
}

std::vector<std::string> world_names() {
  return {"house", "small-rooms", "large-rooms", "three-storey", "campus"};
}

Result<World> make_world(const std::string& name, std::uint64_t seed) {
  if (name == "house") return make_house(seed);
  if (name == "small-rooms") return make_small_rooms(seed);
  if (name == "large-rooms") return make_large_rooms(seed);
  if (name == "three-storey") return make_three_storey(seed);
  if (name == "campus") return make_campus(seed);
  std::string names;
  for (const std::string& known : world_names()) names += (names.empty() ? "" : ", ") + known;
  return fail(
      ErrorKind::kInput,
      name + ": no such world and no such file: name a built-in world (" + names + ") or a .ply");
}

}  // namespace cloister
