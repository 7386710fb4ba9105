// The program as a service manager runs it on a robot.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>
#include <linux/mount.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/un.h>

#include "test/support/live_host.hpp"

namespace cloister {
namespace {

namespace fs = std::filesystem;

/// The service manager's end of the socket.
class Manager {
 public:
  explicit Manager(const std::string& address) {
    sockaddr_un name{};
    name.sun_family = AF_UNIX;
    std::memcpy(name.sun_path, address.data(), address.size());
    if (name.sun_path[0] == '@') name.sun_path[0] = '\0';
    fd_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const timeval patience{60, 0};
    REQUIRE(setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience)) == 0);
    const auto length = offsetof(sockaddr_un, sun_path) + address.size();
    REQUIRE(bind(fd_, reinterpret_cast<const sockaddr*>(&name), static_cast<socklen_t>(length)) ==
            0);
  }
  ~Manager() { close(fd_); }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  /// The next message, or nothing in a minute.
  std::string hear() const {
    char buffer[256];
    const ssize_t length = recv(fd_, buffer, sizeof(buffer), 0);
    return {buffer, length < 0 ? 0 : static_cast<std::size_t>(length)};
  }

 private:
  int fd_ = -1;
};

/// Makes every mount read-only, or one of them writable again.
bool set_read_only(const fs::path& mount, bool is_read_only) {
  mount_attr attributes{};
  (is_read_only ? attributes.attr_set : attributes.attr_clr) = MOUNT_ATTR_RDONLY;
  return syscall(SYS_mount_setattr, AT_FDCWD, mount.c_str(), is_read_only ? AT_RECURSIVE : 0,
                 &attributes, sizeof(attributes)) == 0;
}

TEST_CASE("a service manager hears when the mapper is ready, that it lives, and when it stops") {
  Host host;
  if (!host.is_there()) return;
  for (const std::string& address :
       {std::string("@cloister-test"), (host.folder.path() / "notify").string()}) {
    CAPTURE(address);
    const Manager manager(address);
    setenv("NOTIFY_SOCKET", address.c_str(), 1);
    setenv("WATCHDOG_USEC", "200000", 1);
    Background run = host.run();
    CHECK(manager.hear() == "READY=1");
    // Before the sensor is known, and after.
    CHECK(manager.hear() == "WATCHDOG=1");
    {
      Robot robot;
      robot.map_first_scan();
    }
    CHECK(manager.hear() == "WATCHDOG=1");
    run.signal(SIGTERM);
    std::string heard = manager.hear();
    while (heard == "WATCHDOG=1") heard = manager.hear();
    CHECK(heard == "STOPPING=1");
    CHECK(run.wait() == 0);
  }
}

TEST_CASE("a mapper that nobody watches, or whose manager has gone, runs all the same") {
  Host host;
  if (!host.is_there()) return;
  setenv("NOTIFY_SOCKET", (host.folder.path() / "nobody").c_str(), 1);
  setenv("WATCHDOG_USEC", "rubbish", 1);
  Background run = host.run();
  Robot robot;
  robot.map_first_scan();
  CHECK(run.end(SIGTERM) == 0);
  CHECK(read_text(host.log("run")) == "");
}

TEST_CASE("an unprivileged user on a read-only system needs one writable directory") {
  Host host;
  if (!host.is_there()) return;
  // Where the program was built, another user may not be let in.
  fs::permissions(host.folder.path(), fs::perms(0755));
  const fs::path program = host.folder.path() / "cloister";
  fs::copy_file(CLOISTER_PROGRAM, program);
  const fs::path writable = host.folder.path() / "state";
  fs::create_directory(writable);
  REQUIRE(mount("tmpfs", writable.c_str(), "tmpfs", 0, "mode=0777") == 0);
  if (!set_read_only("/", true)) {
    MESSAGE("skipped, since this kernel cannot make mounts read-only: " << std::strerror(errno));
    return;
  }
  REQUIRE(set_read_only(writable, false));
  REQUIRE(open("/tmp/file", O_WRONLY | O_CREAT | O_CLOEXEC, 0600) == -1);
  REQUIRE(errno == EROFS);
  const rlimit none{0, 0};
  REQUIRE(setrlimit(RLIMIT_RTPRIO, &none) == 0);

  const fs::path log = writable / "log";
  Background run(
      {"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", program.string(), "run",
       "--out", (writable / "map").string(), "--set", "runtime.integration_priority=10"},
      log);
  {
    Robot robot;
    robot.map_first_scan();
  }
  CHECK(run.end(SIGTERM) == 0);
  CHECK(fs::file_size(writable / "map" / "map.cloister") > 0);
  CHECK(fs::file_size(writable / "map" / "report.html") > 0);
  // The priority is not to be had, is missed, and that is all.
  const std::string said = read_text(log);
  CHECK(said.find("runtime.integration_priority = 10 is not permitted") != std::string::npos);
  CHECK(std::count(said.begin(), said.end(), '\n') == 1);
}

}  // namespace
}  // namespace cloister
