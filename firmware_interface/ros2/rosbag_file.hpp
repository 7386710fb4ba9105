#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mapping/core/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace cloister::ros2 {

/// One topic of a recording.
struct BagTopic {
  std::string name;  ///< "/ouster/points"
  std::string type;  ///< "sensor_msgs/msg/PointCloud2"
};

/// A recording of rosbag2 in SQLite: one .db3 file, or a folder of those that a long recording was split into.
/// metadata.yaml is not needed.
///
/// Messages are found by topic in the order in which they were received; their data are read one by one. Compressed
/// recordings are refused, with what to do about them. A file is never written to, so that it may lie on a medium that
/// cannot be.
///
/// Threads: one at a time. Memory: 24 bytes a message of the topics asked for.
class RosbagFile {
 public:
  /// Where a message lies.
  struct Entry {
    std::int64_t received_ns = 0;  ///< recorder's clock
    std::int64_t row = 0;
    std::int32_t file = 0;
  };

  /// True when a path looks like such a recording: a .db3 file, or a folder that holds one.
  [[nodiscard]] static bool is_one(const std::filesystem::path& path);

  /// @return kInput, naming the file, when it is missing, compressed, or no recording
  [[nodiscard]] static Result<RosbagFile> open(const std::filesystem::path& path);

  /// Topics of all files, each once, by name.
  [[nodiscard]] const std::vector<BagTopic>& topics() const { return topics_; }
  /// The messages of one topic as they were received.
  [[nodiscard]] Result<std::vector<Entry>> messages(const std::string& topic);
  /// A message's CDR; it stays until the next call.
  [[nodiscard]] Result<std::span<const std::byte>> data(const Entry& entry);

 private:
  struct Closer {
    void operator()(sqlite3* database) const;
    void operator()(sqlite3_stmt* statement) const;
  };
  using Database = std::unique_ptr<sqlite3, Closer>;
  using Statement = std::unique_ptr<sqlite3_stmt, Closer>;
  struct File {
    std::filesystem::path path;
    Database database;
    Statement read;  ///< one message's data, by its row
  };

  [[nodiscard]] static Result<File> open_file(const std::filesystem::path& path);
  [[nodiscard]] static Result<Statement> prepare(const File& file, const char* sql);
  [[nodiscard]] Result<void> read_topics(const File& file);

  std::vector<File> files_;
  std::vector<BagTopic> topics_;
};

}  // namespace cloister::ros2
