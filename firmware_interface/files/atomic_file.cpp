#include "firmware_interface/files/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace cloister {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{256} << 10;
constexpr int kMaxNames = 1000;

Error cannot_write(const std::filesystem::path& path, std::string_view what, int error) {
  return {ErrorKind::kResource, path.string() + ": " + std::string(what) + ": " +
                                    std::generic_category().message(error) +
                                    "; check the directory, its permissions and free space"};
}

/// Makes the rename itself durable. Not every file system can, and the file is in place either way.
void sync_directory_of(const std::filesystem::path& path) {
  const std::filesystem::path directory = path.has_parent_path() ? path.parent_path() : ".";
  const int fd = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

}  // namespace

Result<AtomicFile> AtomicFile::open(const std::filesystem::path& path) {
  AtomicFile file;
  file.path_ = path;
  // Leftovers of a killed process may have the first names; O_EXCL passes over them.
  for (int k = 0; k < kMaxNames && file.fd_ < 0; ++k) {
    file.temporary_path_ = path;
    file.temporary_path_ += "." + std::to_string(::getpid()) + "-" + std::to_string(k) + ".tmp";
    file.fd_ = ::open(file.temporary_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file.fd_ < 0 && errno != EEXIST) break;
  }
  if (file.fd_ < 0) {
    const int error = errno;
    file.temporary_path_.clear();
    return tl::unexpected(cannot_write(path, "cannot be created", error));
  }
  file.buffer_.reserve(kBufferBytes);
  return file;
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_path_(std::exchange(other.temporary_path_, {})),
      fd_(std::exchange(other.fd_, -1)),
      buffer_(std::move(other.buffer_)),
      failure_(std::move(other.failure_)) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  if (this == &other) return *this;
  discard();
  path_ = std::move(other.path_);
  temporary_path_ = std::exchange(other.temporary_path_, {});
  fd_ = std::exchange(other.fd_, -1);
  buffer_ = std::move(other.buffer_);
  failure_ = std::move(other.failure_);
  return *this;
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::discard() {
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  if (!temporary_path_.empty()) ::unlink(temporary_path_.c_str());
  temporary_path_.clear();
}

Result<void> AtomicFile::remember_failure(std::string_view what, int error) {
  failure_ = cannot_write(path_, what, error);
  return tl::unexpected(*failure_);
}

Result<void> AtomicFile::flush() {
  std::string_view left = buffer_;
  while (!left.empty()) {
    const ssize_t count = ::write(fd_, left.data(), left.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return remember_failure("cannot be written", errno);
    left.remove_prefix(static_cast<std::size_t>(count));
  }
  buffer_.clear();
  return {};
}

Result<void> AtomicFile::write(std::string_view text) {
  if (failure_) return tl::unexpected(*failure_);
  if (fd_ < 0) return remember_failure("is closed already", EBADF);
  while (!text.empty()) {
    const std::size_t count = std::min(text.size(), kBufferBytes - buffer_.size());
    buffer_.append(text, 0, count);
    text.remove_prefix(count);
    if (buffer_.size() < kBufferBytes) break;
    if (auto flushed = flush(); !flushed) return flushed;
  }
  return {};
}

Result<void> AtomicFile::write(std::span<const std::byte> bytes) {
  return write(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

Result<void> AtomicFile::commit() {
  if (failure_) return tl::unexpected(*failure_);
  if (fd_ < 0) return remember_failure("is closed already", EBADF);
  if (auto flushed = flush(); !flushed) return flushed;
  // Pipes and a few network mounts cannot sync; that is no reason to lose the file.
  if (::fsync(fd_) != 0 && errno != EINVAL && errno != ENOTSUP) {
    return remember_failure("cannot be brought to the disk", errno);
  }
  if (::close(std::exchange(fd_, -1)) != 0) return remember_failure("cannot be closed", errno);
  if (::rename(temporary_path_.c_str(), path_.c_str()) != 0) {
    return remember_failure("cannot take its name", errno);
  }
  temporary_path_.clear();
  sync_directory_of(path_);
  return {};
}

Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text) {
  auto file = AtomicFile::open(path);
  if (!file) return tl::unexpected(file.error());
  if (auto written = file->write(text); !written) return written;
  return file->commit();
}

}  // namespace cloister
