#include "firmware_interface/files/read_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <stdexcept>
#include <system_error>

#include <sys/stat.h>

namespace cloister {
namespace {

tl::unexpected<Error> cannot_read(const std::filesystem::path& path, int error) {
  return fail(ErrorKind::kInput, path.string() +
                                     ": cannot be read: " + std::generic_category().message(error) +
                                     "; check the path and its permissions");
}

Result<std::string> read_all(int fd, const std::filesystem::path& path) {
  struct stat status = {};
  if (::fstat(fd, &status) != 0) return cannot_read(path, errno);
  if (S_ISDIR(status.st_mode)) return cannot_read(path, EISDIR);
  std::string bytes;
  // One byte more than the file claims, so that its end is seen without growing.
  // Pipes claim nothing and grow.
  std::size_t filled = 0;
  bytes.resize(static_cast<std::size_t>(status.st_size) + 1);
  while (true) {
    if (filled == bytes.size()) bytes.resize(bytes.size() * 2 + 65536);
    const ssize_t count = ::read(fd, bytes.data() + filled, bytes.size() - filled);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return cannot_read(path, errno);
    if (count == 0) break;
    filled += static_cast<std::size_t>(count);
  }
  bytes.resize(filled);
  return bytes;
}

}  // namespace

Result<std::string> read_file(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return cannot_read(path, errno);
  Result<std::string> bytes;
  try {
    bytes = read_all(fd, path);
  } catch (const std::bad_alloc&) {
    bytes = fail(ErrorKind::kResource, path.string() + ": does not fit into memory");
  } catch (const std::length_error&) {
    bytes = fail(ErrorKind::kResource, path.string() + ": does not fit into memory");
  }
  ::close(fd);
  return bytes;
}

}  // namespace cloister
