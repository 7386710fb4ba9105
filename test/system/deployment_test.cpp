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
#include <fstream>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

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

/// A process that does nothing, in a network of its own that `arguments` of `nsenter` lead to.
class Network {
 public:
  explicit Network(const fs::path& log) : process_({"unshare", "--net", "sleep", "600"}, log) {
    // Until it has left this network, it is in it.
    const fs::path theirs = "/proc/" + std::to_string(process_.id()) + "/ns/net";
    std::error_code error;
    const fs::path ours = fs::read_symlink("/proc/self/ns/net");
    for (int i = 0; i < 1000 && fs::read_symlink(theirs, error) == ours; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  [[nodiscard]] std::string id() const { return std::to_string(process_.id()); }
  /// This program, started in that network.
  [[nodiscard]] std::vector<std::string> within(std::vector<std::string> program) const {
    program.insert(program.begin(), {"nsenter", "--net", "--target", id()});
    return program;
  }

 private:
  Background process_;
};

TEST_CASE("a mapper behind translated addresses is reached at the one that it is told") {
  Host host;
  if (!host.is_there()) return;
  const Network container(host.log("container"));
  const Network robot(host.log("robot"));
  // This network lies between them, and lets the robot in as a computer does with the published ports of a container.
  const fs::path script = host.folder.path() / "lay";
  std::ofstream(script)
      << "set -e\n"
         "join() {\n"
         "  ip link add $1 type veth peer name eth0 netns $2\n"
         "  ip address add $3.1/24 dev $1\n"
         "  ip link set $1 up\n"
         "  nsenter --net --target $2 ip address add $3.2/24 dev eth0\n"
         "  nsenter --net --target $2 ip link set lo up\n"
         "  nsenter --net --target $2 ip link set eth0 up\n"
         "}\n"
         "join inner $1 198.51.100\n"
         "join outer $2 192.0.2\n"
         "nsenter --net --target $1 ip route add default via 198.51.100.1\n"
         "echo 1 >/proc/sys/net/ipv4/ip_forward\n"
         "nft add table ip nat\n"
         "nft 'add chain ip nat in { type nat hook prerouting priority -100; }'\n"
         "nft 'add chain ip nat out { type nat hook postrouting priority 100; }'\n"
         "nft add rule ip nat in iifname outer udp dport 21000-21099 "
         "dnat to 198.51.100.2\n"
         "nft add rule ip nat out oifname outer masquerade\n";
  const ProgramResult laid =
      run_program("sh", script.string() + " " + container.id() + " " + robot.id());
  if (laid.exit_status != 0) {
    MESSAGE("skipped, since addresses cannot be translated here: " << laid.err);
    return;
  }
  const std::vector<std::string> common = {"--set", "dds.interface=eth0",
                                           "--set", "dds.first_port=21000",
                                           "--set", "dds.shared_memory=off"};
  const auto start = [&](const Network& network, std::vector<std::string> program,
                         const std::string& name) {
    program.insert(program.end(), common.begin(), common.end());
    return Background(network.within(program), host.log(name));
  };
  Background run =
      start(container,
            {CLOISTER_PROGRAM, "run", "--out", host.out().string(), "--set", kRoom, "--set",
             "dds.peers=192.0.2.2", "--set", "dds.external_address=192.0.2.1"},
            "run");
  Background play = start(robot,
                          {CLOISTER_PROGRAM, "play", CLOISTER_HOUSE_MISSION, "--rate", "2", "--set",
                           "dds.peers=192.0.2.1"},
                          "play");
  CHECK(play.wait() == 0);
  CHECK(run.end(SIGTERM) == 0);
  CHECK(host.summary()["scans"]["integrated"].get<int>() > 0);
  CHECK(host.map_loads());
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
