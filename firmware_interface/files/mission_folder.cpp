#include "firmware_interface/files/mission_folder.hpp"

#include <algorithm>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>

#include "firmware_interface/files/line_reader.hpp"
#include "firmware_interface/files/mission_json.hpp"
#include "firmware_interface/files/read_file.hpp"
#include "firmware_interface/files/tum_file.hpp"

namespace cloister {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

tl::unexpected<Error> fail_for(const fs::path& path, std::string_view problem) {
  return fail(ErrorKind::kInput, path.string() + ": " + std::string(problem));
}

/// The visible files of a directory with one of two suffixes, by name.
Result<std::vector<fs::path>> list_files(const fs::path& directory, std::string_view suffix,
                                         std::string_view other_suffix) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(directory, error), end; !error && it != end; it.increment(error)) {
    const fs::path& path = it->path();
    const fs::path extension = path.extension();
    if (extension != suffix && extension != other_suffix) continue;
    if (path.filename().string().starts_with('.') || !is_file(path)) continue;
    files.push_back(path);
  }
  if (error) return fail_for(directory, "cannot be listed: " + error.message());
  std::ranges::sort(files);
  return files;
}

/// "PREFIX<a>_<b>" as its two numbers, which are digits only.
std::optional<std::pair<std::int64_t, std::int64_t>> parse_name(std::string_view stem,
                                                                std::string_view prefix) {
  if (!stem.starts_with(prefix)) return std::nullopt;
  stem.remove_prefix(prefix.size());
  const auto is_digit_or_bar = [](char c) { return (c >= '0' && c <= '9') || c == '_'; };
  const auto bar = stem.find('_');
  if (bar == stem.npos || !std::ranges::all_of(stem, is_digit_or_bar)) return std::nullopt;
  const auto a = parse_int(stem.substr(0, bar));
  const auto b = parse_int(stem.substr(bar + 1));
  if (!a || !b) return std::nullopt;
  return std::pair(*a, *b);
}

Result<std::vector<CloudFile>> find_clouds(const fs::path& directory) {
  const auto files = list_files(directory, ".pcd", ".pcd");
  if (!files) return tl::unexpected(files.error());
  std::vector<CloudFile> clouds;
  for (const fs::path& path : *files) {
    const auto numbers = parse_name(path.stem().string(), "cloud_");
    const auto stamp = numbers ? make_stamp(numbers->first, numbers->second) : std::nullopt;
    if (!stamp)
      return fail_for(path, "the name is not cloud_<sec>_<nsec>.pcd; rename or remove it");
    clouds.push_back({path, *stamp});
  }
  if (clouds.empty()) return fail_for(directory, "holds no cloud_<sec>_<nsec>.pcd; add the clouds");
  // By number, since nanoseconds need not be padded.
  std::ranges::stable_sort(clouds, {}, &CloudFile::stamp);
  const auto twin = std::ranges::adjacent_find(clouds, {}, &CloudFile::stamp);
  if (twin != clouds.end()) {
    return fail_for((twin + 1)->path, "has the stamp of another cloud; remove one of them");
  }
  return clouds;
}

Result<std::vector<GraphFile>> find_snapshots(const fs::path& directory) {
  const auto files = list_files(directory, ".g2o", ".g2o");
  if (!files) return tl::unexpected(files.error());
  std::vector<GraphFile> graphs;
  for (const fs::path& path : *files) {
    const auto numbers = parse_name(path.stem().string(), "");
    if (!numbers || numbers->second > kMaxStamp_ns) {
      return fail_for(path, "the name is not NNNNNN_<stamp_ns>.g2o; rename or remove it");
    }
    graphs.push_back({path, SensorTime{numbers->second}, numbers->first});
  }
  std::ranges::stable_sort(graphs, {},
                           [](const GraphFile& g) { return std::tuple(g.stamp, g.number); });
  return graphs;
}

/// The one graph at the top of the mission, if any.
Result<std::vector<GraphFile>> find_single_graph(const fs::path& directory) {
  if (const fs::path usual = directory / "slam_pose_graph.slam"; is_file(usual)) {
    return std::vector{GraphFile{usual, kBeforeMission, 0}};
  }
  const auto files = list_files(directory, ".g2o", ".slam");
  if (!files) return tl::unexpected(files.error());
  if (files->size() > 1) {
    return fail_for(files->at(1), "is a second graph beside " + files->at(0).filename().string() +
                                      "; keep one, or put snapshots into pose_graph/");
  }
  std::vector<GraphFile> graphs;
  for (const fs::path& path : *files) graphs.push_back({path, kBeforeMission, 0});
  return graphs;
}

/// Fills `graphs` and `node_stamps_path`.
Result<void> find_graphs(MissionFolder& mission) {
  fs::path home = mission.path / "pose_graph";
  if (is_folder(home)) {
    auto snapshots = find_snapshots(home);
    if (!snapshots) return tl::unexpected(std::move(snapshots.error()));
    mission.graphs = std::move(*snapshots);
  }
  if (mission.graphs.empty()) {
    home = mission.path;
    auto single = find_single_graph(home);
    if (!single) return tl::unexpected(std::move(single.error()));
    mission.graphs = std::move(*single);
  }
  if (is_file(home / "nodes.tum")) mission.node_stamps_path = home / "nodes.tum";
  if (mission.graphs.empty()) {
    mission.warnings.push_back(mission.path.string() +
                               ": holds no pose graph; the map follows the odometry alone");
  }
  return {};
}

/// Fills name, `pose_frame` and `T_pose_sensor` as mission.json says, and returns the variant that
/// it asks for. Without the file nothing changes.
Result<std::optional<MissionVariant>> apply_mission_json(MissionFolder& mission) {
  const fs::path path = mission.path / "mission.json";
  if (!is_file(path)) return std::nullopt;
  const Result<std::string> text = read_file(path);
  if (!text) return tl::unexpected(text.error());
  auto json = read_mission_json(*text, path.string());
  if (!json) return tl::unexpected(std::move(json.error()));
  if (json->name && !json->name->empty()) mission.name = *json->name;
  mission.pose_frame = json->pose_frame;
  if (json->pose_frame != PoseFrame::kSensor) mission.T_pose_sensor = json->T_pose_sensor;
  return json->variant;
}

}  // namespace

Result<MissionFolder> open_mission(const fs::path& path) {
  if (!is_folder(path)) return fail_for(path, "is not a directory; give a mission's directory");
  MissionFolder mission;
  mission.path = path;
  std::error_code ignored;  // a mission without a name is not worth a failure
  mission.name = fs::canonical(path, ignored).filename().string();
  const auto wanted = apply_mission_json(mission);
  if (!wanted) return tl::unexpected(wanted.error());

  const fs::path packets = path / "lidar.pcap";
  const fs::path clouds = path / "individual_clouds";
  const bool has_packets = is_file(packets);
  const bool has_clouds = is_folder(clouds);
  if (!has_packets && !has_clouds) {
    return fail_for(path, "holds neither lidar.pcap nor individual_clouds/; is this a mission?");
  }
  mission.variant =
      wanted->value_or(has_packets ? MissionVariant::kPackets : MissionVariant::kClouds);
  if (has_packets && has_clouds && !*wanted) {
    mission.warnings.push_back(path.string() +
                               ": holds lidar.pcap and individual_clouds/; the packets "
                               "are read, unless mission.json sets \"variant\"");
  }
  if (is_file(path / "odometry.tum")) mission.odometry_path = path / "odometry.tum";

  if (mission.variant == MissionVariant::kPackets) {
    mission.packets_path = packets;
    mission.metadata_path = path / "metadata.json";
    if (!has_packets) return fail_for(packets, "is missing; add the sensor's packets");
    if (!is_file(mission.metadata_path)) {
      return fail_for(mission.metadata_path, "is missing; add the sensor's metadata");
    }
    if (!mission.odometry_path) {
      return fail_for(path / "odometry.tum",
                      "is missing; packets cannot be placed without odometry");
    }
  } else {
    if (!has_clouds) return fail_for(clouds, "is missing; add the clouds");
    auto found = find_clouds(clouds);
    if (!found) return tl::unexpected(std::move(found.error()));
    mission.clouds = std::move(*found);
    if (mission.pose_frame == PoseFrame::kLidar) {
      mission.pose_frame = PoseFrame::kSensor;
      mission.T_pose_sensor = Pose::Identity();
    }
  }
  if (auto found = find_graphs(mission); !found) return tl::unexpected(std::move(found.error()));
  if (mission.graphs.empty() && !mission.odometry_path) {
    return fail_for(path, "holds no pose graph and no odometry.tum; add one to place the clouds");
  }
  return mission;
}

Result<PoseGraph> load_graph(const MissionFolder& mission, const GraphFile& file,
                             const G2oOptions& options, G2oStats* stats) {
  auto graph = load_g2o(file.path, options, stats);
  if (!graph) return graph;
  graph->stamp = file.stamp;
  const auto without_stamp = std::ranges::find(graph->nodes, false, &GraphNode::has_stamp);
  if (without_stamp == graph->nodes.end()) return graph;
  if (!mission.node_stamps_path) {
    return fail_for(file.path, "vertex " + std::to_string(without_stamp->id) +
                                   " has no stamp; write VERTEX_SE3:QUAT_TIME or add nodes.tum");
  }
  const auto lines = load_tum(*mission.node_stamps_path, TumOrder::kAsWritten);
  if (!lines) return tl::unexpected(lines.error());
  if (auto set = set_node_stamps(*graph, *lines, mission.node_stamps_path->string()); !set) {
    return tl::unexpected(std::move(set.error()));
  }
  return graph;
}

}  // namespace cloister
