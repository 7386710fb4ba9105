#include "firmware_interface/ros2/rosbag_file.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>

namespace cloister::ros2 {
namespace {

constexpr const char* kSuffix = ".db3";
/// What compressed data begin with (Zstandard, RFC 8878).
constexpr std::array<std::byte, 4> kZstandard = {std::byte{0x28}, std::byte{0xb5}, std::byte{0x2f},
                                                 std::byte{0xfd}};
constexpr const char* kUncompress = "; uncompress the recording with `ros2 bag convert`";

tl::unexpected<Error> fail_for(const std::filesystem::path& path, const std::string& problem) {
  return fail(ErrorKind::kInput, path.string() + ": " + problem);
}

tl::unexpected<Error> fail_for(const std::filesystem::path& path, sqlite3* database) {
  return fail_for(path, std::string("cannot be read as a rosbag2 recording: ") +
                            sqlite3_errmsg(database) + "; try `sqlite3 FILE .recover`");
}

/// The path as a URI, so that it can say how it is to be opened.
std::string uri_of(const std::filesystem::path& path) {
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).string()) {
    if (c == '%' || c == '?' || c == '#') {
      const auto byte = static_cast<unsigned char>(c);
      uri += {'%', kHex[byte >> 4], kHex[byte & 15]};
    } else {
      uri += c;
    }
  }
  // A log beside the file means that its recorder did not end, or has not yet: then it must be read as well.
  std::error_code error;
  const auto log_bytes = std::filesystem::file_size(path.string() + "-wal", error);
  return uri + (error || log_bytes == 0 ? "?immutable=1" : "?mode=ro");
}

std::string text_of(sqlite3_stmt* statement, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
  return text != nullptr ? text : "";
}

}  // namespace

void RosbagFile::Closer::operator()(sqlite3* database) const { sqlite3_close_v2(database); }
void RosbagFile::Closer::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

bool RosbagFile::is_one(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return path.extension() == kSuffix;
  for (const auto& entry : std::filesystem::directory_iterator(path, error)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(kSuffix) || name.ends_with(std::string(kSuffix) + ".zstd")) return true;
  }
  return false;
}

Result<RosbagFile::Statement> RosbagFile::prepare(const File& file, const char* sql) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(file.database.get(), sql, -1, &statement, nullptr) != SQLITE_OK) {
    return fail_for(file.path, file.database.get());
  }
  return Statement(statement);
}

Result<RosbagFile::File> RosbagFile::open_file(const std::filesystem::path& path) {
  File file;
  file.path = path;
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return fail_for(path, "no such recording");
  sqlite3* database = nullptr;
  const int opened = sqlite3_open_v2(uri_of(path).c_str(), &database,
                                     SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
  file.database.reset(database);
  if (opened != SQLITE_OK) return fail_for(path, database);
  auto read = prepare(file, "SELECT data FROM messages WHERE id = ?");
  if (!read) return tl::unexpected(read.error());
  file.read = std::move(*read);
  return file;
}

Result<RosbagFile> RosbagFile::open(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    for (const auto& entry : std::filesystem::directory_iterator(path, error)) {
      if (entry.path().extension() == ".zstd") {
        return fail_for(entry.path(), std::string("is compressed") + kUncompress);
      }
      if (entry.path().extension() == kSuffix) paths.push_back(entry.path());
    }
    if (paths.empty()) return fail_for(path, "holds no .db3 file");
    std::ranges::sort(paths);
  } else {
    paths.push_back(path);
  }
  RosbagFile bag;
  for (const std::filesystem::path& part : paths) {
    auto file = open_file(part);
    if (!file) return tl::unexpected(file.error());
    if (auto read = bag.read_topics(*file); !read) return tl::unexpected(read.error());
    bag.files_.push_back(std::move(*file));
  }
  std::ranges::sort(bag.topics_, {}, &BagTopic::name);
  return bag;
}

Result<void> RosbagFile::read_topics(const File& file) {
  auto rows = prepare(file, "SELECT name, type, serialization_format FROM topics");
  if (!rows) return tl::unexpected(rows.error());
  int status = SQLITE_OK;
  while ((status = sqlite3_step(rows->get())) == SQLITE_ROW) {
    BagTopic topic{text_of(rows->get(), 0), text_of(rows->get(), 1)};
    if (text_of(rows->get(), 2) != "cdr") continue;  // none of ours
    if (std::ranges::find(topics_, topic.name, &BagTopic::name) == topics_.end()) {
      topics_.push_back(std::move(topic));
    }
  }
  if (status != SQLITE_DONE) return fail_for(file.path, file.database.get());
  return {};
}

Result<std::vector<RosbagFile::Entry>> RosbagFile::messages(const std::string& topic) {
  std::vector<Entry> entries;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const File& file = files_[i];
    auto rows = prepare(file,
                        "SELECT timestamp, id FROM messages "
                        "WHERE topic_id IN (SELECT id FROM topics WHERE name = ?)");
    if (!rows) return tl::unexpected(rows.error());
    sqlite3_bind_text(rows->get(), 1, topic.c_str(), -1, SQLITE_STATIC);
    int status = SQLITE_OK;
    while ((status = sqlite3_step(rows->get())) == SQLITE_ROW) {
      entries.push_back({sqlite3_column_int64(rows->get(), 0), sqlite3_column_int64(rows->get(), 1),
                         static_cast<std::int32_t>(i)});
    }
    if (status != SQLITE_DONE) return fail_for(file.path, file.database.get());
  }
  std::ranges::sort(entries, [](const Entry& a, const Entry& b) {
    return std::tie(a.received_ns, a.file, a.row) < std::tie(b.received_ns, b.file, b.row);
  });
  return entries;
}

Result<std::span<const std::byte>> RosbagFile::data(const Entry& entry) {
  const File& file = files_[static_cast<std::size_t>(entry.file)];
  sqlite3_reset(file.read.get());
  sqlite3_bind_int64(file.read.get(), 1, entry.row);
  if (sqlite3_step(file.read.get()) != SQLITE_ROW) return fail_for(file.path, file.database.get());
  const auto* bytes = static_cast<const std::byte*>(sqlite3_column_blob(file.read.get(), 0));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(file.read.get(), 0));
  const std::span<const std::byte> data(bytes, bytes != nullptr ? size : 0);
  if (data.size() >= kZstandard.size() &&
      std::ranges::equal(data.first(kZstandard.size()), kZstandard)) {
    return fail_for(file.path,
                    "message " + std::to_string(entry.row) + " is compressed" + kUncompress);
  }
  return data;
}

}  // namespace cloister::ros2
