#include "bench/simulate/world.hpp"

#include "bench/simulate/house.hpp"

namespace cloister {

std::vector<std::string> world_names() { return {"house"}; }

Result<World> make_world(const std::string& name, std::uint64_t seed) {
  if (name == "house") return make_house(seed);
  return fail(ErrorKind::kInput,
              name + ": no such world and no such file: name a built-in world (house) or a .ply");
}

}  // namespace cloister
