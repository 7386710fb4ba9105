#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mapping/core/result.hpp"

namespace cloister {

/// An output file that appears whole or not at all: bytes go to a temporary file in the same
/// directory, which takes the wanted name in `commit()`. A file of that name stays untouched until
/// then.
///
/// Writes are gathered in a buffer of 256 KiB. The first failure sticks: later writes and the
/// commit report it again, so a writer may check only the commit. Without a commit the destructor
/// removes the temporary file. One thread at a time.
class AtomicFile {
 public:
  /// Creates the temporary file. Fails with kResource naming the path; the directory must exist.
  [[nodiscard]] static Result<AtomicFile> open(const std::filesystem::path& path);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  ~AtomicFile();

  Result<void> write(std::string_view text);
  Result<void> write(std::span<const std::byte> bytes);

  /// Brings all bytes to the disk, then renames. To be called once; the file is closed afterwards.
  [[nodiscard]] Result<void> commit();

 private:
  AtomicFile() = default;
  Result<void> flush();
  Result<void> remember_failure(std::string_view what, int error);
  void discard();

  std::filesystem::path path_;
  std::filesystem::path temporary_path_;  ///< empty when there is no temporary file to remove
  int fd_ = -1;
  std::string buffer_;
  std::optional<Error> failure_;
};

/// Writes a whole file at once, as AtomicFile does.
[[nodiscard]] Result<void> write_file_atomically(const std::filesystem::path& path,
                                                 std::string_view text);

}  // namespace cloister
