#include "firmware_interface/files/tum_file.hpp"

#include <string>

#include "firmware_interface/files/line_reader.hpp"
#include "firmware_interface/files/read_file.hpp"

namespace cloister {

Result<std::vector<StampedPose>> read_tum(std::string_view text, std::string_view file_name,
                                          TumOrder order) {
  std::vector<StampedPose> poses;
  LineReader line(text, file_name);
  while (line.next_line()) {
    StampedPose pose;
    if (!line.read(pose.stamp) || !line.read(pose.T_O_B) || !line.read_end()) return line.failure();
    if (order == TumOrder::kAscending && !poses.empty()) {
      if (pose.stamp < poses.back().stamp) {
        return line.failure("the stamp is earlier than the one before; sort the lines by time");
      }
      if (pose.stamp == poses.back().stamp) poses.pop_back();
    }
    poses.push_back(pose);
  }
  return poses;
}

Result<std::vector<StampedPose>> load_tum(const std::filesystem::path& path, TumOrder order) {
  const Result<std::string> text = read_file(path);
  if (!text) return tl::unexpected(text.error());
  return read_tum(*text, path.string(), order);
}

Result<void> set_node_stamps(PoseGraph& graph, std::span<const StampedPose> lines,
                             std::string_view file_name) {
  if (lines.size() < graph.nodes.size()) {
    return fail(ErrorKind::kInput, std::string(file_name) + ":" + std::to_string(lines.size()) +
                                       ": the last line; the graph has " +
                                       std::to_string(graph.nodes.size()) +
                                       " nodes; write a line for every node, by ascending id");
  }
  for (std::size_t k = 0; k < graph.nodes.size(); ++k) {
    GraphNode& node = graph.nodes[k];
    if (node.has_stamp) continue;
    node.stamp = lines[k].stamp;
    node.has_stamp = true;
  }
  return {};
}

}  // namespace cloister
