#include <cmath>
#include <sstream>
#include <string>

// OctoMap would otherwise tell about its progress on stderr.
#define OCTOMAP_NODEBUGOUT
#include <octomap/OcTree.h>

#include "firmware_interface/files/text_format.hpp"
#include "firmware_interface/map/atomic_ostream.hpp"
#include "firmware_interface/map/combined_blocks.hpp"
#include "firmware_interface/map/map_export.hpp"
#include "firmware_interface/map/map_query.hpp"

namespace cloister {
namespace {

constexpr int kTreeDepth = 16;
constexpr int kBlockDepth = kTreeDepth - kBlockShift;
/// OctoMap's keys are 16 bits, half of them negative.
constexpr int kKeyOffset = 1 << (kTreeDepth - 1);

enum class TreeValues { kLogOdds, kState };

/// An OctoMap that is filled block by block. A block of the grid is exactly a node three levels
/// above the leaves; equal leaves are joined as soon as their block is written, so the tree hardly
/// grows beyond its final size.
class BlockTree : public octomap::OcTree {
 public:
  BlockTree(const MapInfo& info, TreeValues values)
      : octomap::OcTree(info.voxel_size_m), values_(values) {
    setClampingThresMin(octomap::probability(info.log_odds_min));
    setClampingThresMax(octomap::probability(info.log_odds_max));
    setOccupancyThres(0.5);
  }

  void write_block(const CombinedBlock& block) {
    if (root == nullptr) {
      root = new octomap::OcTreeNode();
      ++tree_size;
    }
    size_changed = true;
    // Blocks are nodes of the tree, since the key of the grid's origin is a multiple of 8.
    const VoxelCoord key = block.coord * kBlockEdge + VoxelCoord::Constant(kKeyOffset);
    octomap::OcTreeNode* node = root;
    for (int depth = 0; depth < kBlockDepth; ++depth) {
      const int bit = kTreeDepth - 1 - depth;
      const unsigned child = static_cast<unsigned>(
          (key.x() >> bit & 1) | (key.y() >> bit & 1) << 1 | (key.z() >> bit & 1) << 2);
      node =
          nodeChildExists(node, child) ? getNodeChild(node, child) : createNodeChild(node, child);
    }
    write_node(node, block, {0, 0, 0}, kBlockEdge);
  }

  /// Joins equal nodes above the blocks, and gives the others the highest value of their children.
  /// Call once, at the end. (OctoMap's own prune() stops at the first level from below where there
  /// is nothing left to join.)
  void finish() {
    if (root != nullptr) finish_node(root, 0);
  }

 private:
  void finish_node(octomap::OcTreeNode* node, int depth) {
    if (depth == kBlockDepth) return;
    for (unsigned i = 0; i < 8; ++i) {
      if (nodeChildExists(node, i)) finish_node(getNodeChild(node, i), depth + 1);
    }
    if (!pruneNode(node)) node->updateOccupancyChildren();
  }

  void write_node(octomap::OcTreeNode* node, const CombinedBlock& block, const VoxelCoord& low,
                  int edge) {
    if (edge == 1) {
      const LogOdds log_odds = block.voxels[index_in_block(low)];
      node->setLogOdds(values_ == TreeValues::kLogOdds
                           ? static_cast<float>(natural_log_odds(log_odds))
                           : (log_odds < 0 ? getClampingThresMinLog() : getClampingThresMaxLog()));
      return;
    }
    const int half = edge / 2;
    for (unsigned i = 0; i < 8; ++i) {
      const VoxelCoord child_low = low + half * VoxelCoord(i & 1, i >> 1 & 1, i >> 2);
      if (is_known(block, child_low, half)) {
        write_node(createNodeChild(node, i), block, child_low, half);
      }
    }
    if (!pruneNode(node)) node->updateOccupancyChildren();
  }

  [[nodiscard]] static bool is_known(const CombinedBlock& block, const VoxelCoord& low, int edge) {
    for (int z = low.z(); z < low.z() + edge; ++z) {
      for (int y = low.y(); y < low.y() + edge; ++y) {
        for (int x = low.x(); x < low.x() + edge; ++x) {
          if (block.voxels[index_in_block(x, y, z)] != kUnknownLogOdds) return true;
        }
      }
    }
    return false;
  }

  TreeValues values_;
};

/// The header of a .bt file; OctoMap's own writer of it talks to stderr.
[[nodiscard]] std::string binary_header(const BlockTree& tree) {
  std::string header = "# Octomap OcTree binary file\nid OcTree\nsize ";
  append_number(header, tree.size());
  header += "\nres ";
  append_number(header, tree.getResolution());
  return header + "\ndata\n";
}

Result<void> fill(BlockTree& tree, const MapView& map) {
  const bool is_within = for_each_combined_block(
      map, kKeyOffset, [&](const CombinedBlock& block) { tree.write_block(block); });
  if (!is_within) {
    const long reach_m = std::lround(kKeyOffset * map.info.voxel_size_m);
    return fail(ErrorKind::kResource, "the map reaches farther from M's origin than the " +
                                          std::to_string(reach_m) +
                                          " m that OctoMap can hold at this voxel size");
  }
  tree.finish();
  return {};
}

}  // namespace

Result<std::string> octomap_data(const MapView& map, bool with_log_odds) {
  BlockTree tree(map.info, with_log_odds ? TreeValues::kLogOdds : TreeValues::kState);
  if (auto filled = fill(tree, map); !filled) return tl::unexpected(filled.error());
  std::ostringstream stream;
  if (with_log_odds) {
    tree.writeData(stream);
  } else if (tree.size() > 0) {
    tree.writeBinaryData(stream);
  }
  return stream.str();
}

Result<void> export_octomap(const MapView& map, const std::filesystem::path& path,
                            bool with_log_odds) {
  BlockTree tree(map.info, with_log_odds ? TreeValues::kLogOdds : TreeValues::kState);
  if (auto filled = fill(tree, map); !filled) {
    return fail(filled.error().kind, path.string() + ": " + filled.error().message + "; use .vdb");
  }
  Result<AtomicFile> file = AtomicFile::open(path);
  if (!file) return tl::unexpected(file.error());
  // What goes wrong with the disk stays with the file.
  AtomicOstream stream(*file);
  if (with_log_odds) {
    static_cast<void>(tree.write(stream));
  } else {
    stream << binary_header(tree);
    if (tree.size() > 0) tree.writeBinaryData(stream);
  }
  return file->commit();
}

}  // namespace cloister
