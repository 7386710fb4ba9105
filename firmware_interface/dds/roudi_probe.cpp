#include "firmware_interface/dds/roudi_probe.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>

extern "C" {
#include <iceoryx_binding_c/publisher.h>
#include <iceoryx_binding_c/runtime.h>
}

namespace cloister {
namespace {

constexpr const char* kLockFile = "/tmp/iox-unique-roudi.lock";
constexpr const char* kManagementSegment = "/dev/shm/iceoryx_mgmt";
// What Cyclone and iceoryx put before a sample.
constexpr std::size_t kHeaderBytes = 256;
// An answer came: what is left to do takes milliseconds, unless the daemon dies just then.
constexpr std::chrono::milliseconds kSignOff{400};

bool is_locked() {
  const int fd = open(kLockFile, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool is_free = flock(fd, LOCK_EX | LOCK_NB) == 0;
  close(fd);  // which gives the lock back
  return !is_free;
}

/// A new instance of the daemon makes a new segment: its inode and birth name the instance. Its other times do not: they
/// change with every page of it that a process is the first to write.
std::string instance_locator() {
  struct statx status {};
  if (statx(AT_FDCWD, kManagementSegment, 0, STATX_INO | STATX_BTIME, &status) != 0) return {};
  const auto inode = static_cast<std::uint64_t>(status.stx_ino);
  // Before Linux 5.17 there is no birth time in /dev/shm: inodes are not used twice there either.
  const auto born = (status.stx_mask & STATX_BTIME) == 0
                        ? 0
                        : static_cast<std::uint64_t>(status.stx_btime.tv_sec) * 1'000'000 +
                              status.stx_btime.tv_nsec / 1'000;
  // Cyclone wants 16 bytes.
  std::string text = "[";
  for (const std::uint64_t word : {inode, born}) {
    for (int shift = 56; shift >= 0; shift -= 8) {
      char byte[4];
      std::snprintf(byte, sizeof(byte), "%02x:", static_cast<unsigned>(word >> shift & 0xff));
      text += byte;
    }
  }
  text.back() = ']';
  return text;
}

/// In the child: registers, and takes memory for one sample. Never returns.
[[noreturn]] void try_daemon(std::size_t sample_bytes, int answer_fd) {
  // What iceoryx says on its way to an abort is our reason, not the user's.
  const int null = open("/dev/null", O_WRONLY);
  dup2(null, STDOUT_FILENO);
  dup2(null, STDERR_FILENO);
  const std::string name = "cloister-probe-" + std::to_string(getpid());
  iox_runtime_init(name.c_str());
  char answer = 'm';  // memory
  iox_pub_options_t options;
  iox_pub_options_init(&options);
  iox_pub_storage_t storage;
  const iox_pub_t publisher = iox_pub_init(&storage, "cloister", "probe", name.c_str(), &options);
  void* chunk = nullptr;
  if (iox_pub_loan_chunk(publisher, &chunk,
                         static_cast<std::uint32_t>(sample_bytes + kHeaderBytes)) ==
      AllocationResult_SUCCESS) {
    iox_pub_release_chunk(publisher, chunk);
    answer = 'y';
  }
  iox_pub_deinit(publisher);
  (void)!write(answer_fd, &answer, 1);
  // Signs off at the daemon, which _exit would not do: a daemon that believes in a process that is gone aborts when it is
  // to end its clients, and has room for 300 of them.
  std::exit(0);
}

}  // namespace

RouDiState probe_roudi(std::size_t sample_bytes, std::chrono::milliseconds timeout) {
  if (!is_locked()) return {false, "its daemon iox-roudi is not running", {}};
  RouDiState state{false, {}, instance_locator()};
  if (state.locator.empty()) return {false, "its daemon's segment is not in /dev/shm", {}};

  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return {false, "no pipe for asking its daemon", {}};
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) try_daemon(sample_bytes, ends[1]);
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    return {false, "no process for asking its daemon", {}};
  }
  pollfd waited{ends[0], POLLIN, 0};
  int ready = 0;
  do {
    ready = poll(&waited, 1, static_cast<int>(timeout.count()));
  } while (ready < 0 && errno == EINTR);
  char answer = 0;
  if (ready == 1) (void)!read(ends[0], &answer, 1);
  // Its end of the pipe is closed when it has ended.
  const bool has_ended = answer != 0 && poll(&waited, 1, static_cast<int>(kSignOff.count())) == 1;
  close(ends[0]);
  if (!has_ended) kill(child, SIGKILL);
  while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  if (ready != 1) {
    state.reason = "its daemon iox-roudi does not answer";
  } else if (answer == 'y') {
    state.is_usable = true;
  } else {
    state.reason = "its daemon iox-roudi has no memory for samples of " +
                   std::to_string(sample_bytes) + " bytes";
  }
  return state;
}

}  // namespace cloister
