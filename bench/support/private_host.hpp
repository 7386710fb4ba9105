#pragma once

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>

namespace cloister {

/// Moves this process into a network, a /tmp and a /dev/shm of its own, so that missions side by side do not hear
/// each other: only loopback, and everything gone with the process. Needs the right to do so; `why_not` says when it is
/// missing.
class PrivateHost {
 public:
  /// @param keep  folders that must stay visible even where they lie in /tmp
  explicit PrivateHost(const std::vector<std::filesystem::path>& keep) {
    if (unshare(CLONE_NEWNET | CLONE_NEWNS) != 0) {
      fail("unshare");
      return;
    }
    if (mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) fail("mount /");
    if (mount("tmpfs", "/dev/shm", "tmpfs", 0, nullptr) != 0) fail("mount /dev/shm");
    std::vector<int> kept;
    for (const auto& folder : keep)
      kept.push_back(open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    if (mount("tmpfs", "/tmp", "tmpfs", 0, nullptr) != 0) fail("mount /tmp");
    for (std::size_t i = 0; i < keep.size(); ++i) {
      if (!keep[i].string().starts_with("/tmp/")) continue;
      std::error_code error;
      std::filesystem::create_directories(keep[i], error);
      const std::string source = "/proc/self/fd/" + std::to_string(kept[i]);
      if (mount(source.c_str(), keep[i].c_str(), nullptr, MS_BIND | MS_REC, nullptr) != 0)
        fail("mount " + keep[i].string());
    }
    for (const int fd : kept) close(fd);
    raise_loopback();
  }

  /// Empty when all is well.
  [[nodiscard]] const std::string& why_not() const { return why_not_; }

 private:
  void fail(const std::string& what) {
    if (why_not_.empty()) why_not_ = what + ": " + std::strerror(errno);
  }
  void raise_loopback() {
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    ifreq request{};
    std::strcpy(request.ifr_name, "lo");
    request.ifr_flags = IFF_UP | IFF_RUNNING;
    if (ioctl(fd, SIOCSIFFLAGS, &request) != 0) fail("loopback");
    close(fd);
  }

  std::string why_not_;
};

/// What has gone through this network so far.
inline std::uint64_t loopback_bytes() {
  std::ifstream file("/proc/self/net/dev");
  for (std::string line; std::getline(file, line);) {
    const auto at = line.find("lo:");
    if (at != std::string::npos) return std::stoull(line.substr(at + 3));
  }
  return 0;
}

/// A program that runs beside this one, in the same network, and never outlives it.
class Background {
 public:
  /// Starts `arguments[0]`. Its stdout and stderr go to `log`.
  Background(const std::vector<std::string>& arguments, const std::filesystem::path& log) {
    std::vector<char*> argv;
    for (const std::string& argument : arguments)
      argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    const std::string log_path = log.string();
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) _exit(127);
      const int fd = open(log_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
      dup2(fd, STDOUT_FILENO);
      dup2(fd, STDERR_FILENO);
      execvp(argv[0], argv.data());
      _exit(127);
    }
  }
  ~Background() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Background(Background&& other) noexcept : pid_(std::exchange(other.pid_, 0)) {}
  Background& operator=(Background&&) = delete;

  [[nodiscard]] pid_t id() const { return pid_; }
  void signal(int number) const { kill(pid_, number); }

  /// Waits for its end. Returns its exit status, 128 + the signal that ended it, or -1 when it does not end in time.
  int wait(std::chrono::seconds timeout = std::chrono::seconds(120)) {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    int status = 0;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      if (std::chrono::steady_clock::now() > deadline) return -1;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  int end(int number) {
    signal(number);
    return wait();
  }

 private:
  pid_t pid_ = 0;
};

}  // namespace cloister
