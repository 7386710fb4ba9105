#include "bench/ground_truth/truth.hpp"

#include <charconv>
#include <fstream>
#include <string>
#include <system_error>

#include <nlohmann/json.hpp>

#include "bench/simulate/ply_file.hpp"

namespace cloister {

namespace {

using nlohmann::json;

Result<json> read_json_list(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream) return fail(ErrorKind::kInput, path.string() + ": cannot be opened: check the path");
  json value = json::parse(stream, nullptr, false);
  if (value.is_discarded() || !value.is_array()) {
    return fail(ErrorKind::kInput, path.string() + ": not a JSON list: write it again");
  }
  return value;
}

bool read_vector(const json& entry, const char* key, Eigen::Vector3d* out) {
  if (!entry.contains(key) || !entry[key].is_array() || entry[key].size() != 3) return false;
  for (int k = 0; k < 3; ++k) {
    const json& value = entry[key][static_cast<std::size_t>(k)];
    if (!value.is_number()) return false;
    (*out)[k] = value.get<double>();
  }
  return true;
}

}  // namespace

Result<GroundTruth> read_ground_truth(const std::filesystem::path& mission) {
  const std::filesystem::path folder = mission / "ground_truth";
  GroundTruth truth;
  auto poses = read_tum(folder / "trajectory.tum");
  if (!poses) return tl::unexpected(poses.error());
  truth.T_W_L = std::move(*poses);
  auto mesh = read_ply(folder / "mesh.ply");
  if (!mesh) return tl::unexpected(mesh.error());
  truth.mesh_W = std::move(*mesh);
  const auto rooms = read_json_list(folder / "rooms.json");
  if (!rooms) return tl::unexpected(rooms.error());
  for (const json& entry : *rooms) {
    Room room;
    const bool is_whole =
        entry.is_object() && entry.contains("id") && entry["id"].is_number_integer() &&
        entry.contains("name") && entry["name"].is_string() && entry.contains("storey") &&
        entry["storey"].is_number_integer() && read_vector(entry, "min", &room.min_W) &&
        read_vector(entry, "max", &room.max_W);
    if (!is_whole) {
      return fail(ErrorKind::kInput, (folder / "rooms.json").string() + ": room " +
                                         std::to_string(truth.rooms.size()) +
                                         " needs id, name, storey, min and max");
    }
    room.id = entry["id"].get<int>();
    room.name = entry["name"].get<std::string>();
    room.storey = entry["storey"].get<int>();
    truth.rooms.push_back(std::move(room));
  }
  return truth;
}

Result<std::vector<SubmapScans>> read_submaps(const std::filesystem::path& file) {
  const auto list = read_json_list(file);
  if (!list) return tl::unexpected(list.error());
  std::vector<SubmapScans> submaps;
  for (const json& entry : *list) {
    const bool is_whole = entry.is_object() && entry.contains("id") &&
                          entry["id"].is_number_integer() && entry.contains("scan_stamps_ns") &&
                          entry["scan_stamps_ns"].is_array();
    if (!is_whole) {
      return fail(ErrorKind::kInput, file.string() + ": submap " + std::to_string(submaps.size()) +
                                         " needs id and scan_stamps_ns");
    }
    SubmapScans submap{entry["id"].get<std::int64_t>(), {}, {}};
    for (const json& node : entry.value("nodes", json::array())) {
      if (node.is_number_integer()) submap.nodes.push_back(node.get<std::int64_t>());
    }
    for (const json& stamp : entry["scan_stamps_ns"]) {
      if (!stamp.is_number_integer()) {
        return fail(ErrorKind::kInput,
                    file.string() + ": submap " + std::to_string(submap.id) +
                        " has a stamp that is not a whole number of nanoseconds");
      }
      submap.stamps.push_back({stamp.get<std::int64_t>()});
    }
    submaps.push_back(std::move(submap));
  }
  return submaps;
}

Result<std::vector<Closure>> read_wrong_closures(const std::filesystem::path& file) {
  std::vector<Closure> closures;
  std::ifstream stream(file);
  std::string line;
  for (std::size_t number = 1; std::getline(stream, line); ++number) {
    if (number == 1) continue;
    Closure closure;
    const char* const end = line.data() + line.size();
    const auto first = std::from_chars(line.data(), end, closure.first);
    const bool has_both = first.ec == std::errc{} && first.ptr != end && *first.ptr == ',';
    const auto second =
        has_both ? std::from_chars(first.ptr + 1, end, closure.second) : std::from_chars_result{};
    if (!has_both || second.ec != std::errc{} || second.ptr != end) {
      return fail(ErrorKind::kInput,
                  file.string() + ":" + std::to_string(number) + ": needs two node numbers");
    }
    closures.push_back(closure);
  }
  return closures;
}

}  // namespace cloister
