// Faults around a live mission that are not somebody's death: what is full, slow, late, pulled out or wrong.
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>

extern "C" {
#include <iceoryx_binding_c/publisher.h>
#include <iceoryx_binding_c/runtime.h>
}

#include "test/support/live_host.hpp"

namespace cloister {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

/// A process that holds all of RouDi's memory for scans until it is told to give it back.
class Hog {
 public:
  Hog() {
    int holds[2];
    int leave[2];
    REQUIRE(pipe(holds) == 0);
    REQUIRE(pipe(leave) == 0);
    pid_ = fork();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      close(leave[1]);
      hold(holds[1], leave[0]);
    }
    close(holds[1]);
    close(leave[0]);
    char all = 0;
    REQUIRE(read(holds[0], &all, 1) == 1);
    close(holds[0]);
    leave_fd_ = leave[1];
  }
  ~Hog() {
    close(leave_fd_);
    waitpid(pid_, nullptr, 0);
  }
  Hog(const Hog&) = delete;
  Hog& operator=(const Hog&) = delete;

 private:
  [[noreturn]] static void hold(int holds_fd, int leave_fd) {
    constexpr int kPublishers = 12;  // each is allowed eight chunks
    constexpr std::uint32_t kScanBytes = 346'500;
    // iceoryx has much to say about it.
    const int null = open("/dev/null", O_WRONLY);
    dup2(null, STDOUT_FILENO);
    dup2(null, STDERR_FILENO);
    iox_runtime_init("hog");
    std::vector<iox_pub_storage_t> storage(kPublishers);
    std::vector<iox_pub_t> publishers;
    std::vector<std::pair<iox_pub_t, void*>> chunks;
    for (int i = 0; i < kPublishers; ++i) {
      iox_pub_options_t options;
      iox_pub_options_init(&options);
      publishers.push_back(iox_pub_init(&storage[static_cast<std::size_t>(i)], "hog", "hog",
                                        std::to_string(i).c_str(), &options));
    }
    // Again and again, since others give back what they had.
    pollfd end{leave_fd, POLLIN, 0};
    bool is_first = true;
    do {
      for (const iox_pub_t publisher : publishers) {
        void* chunk = nullptr;
        while (iox_pub_loan_chunk(publisher, &chunk, kScanBytes) == AllocationResult_SUCCESS)
          chunks.emplace_back(publisher, chunk);
      }
      if (std::exchange(is_first, false)) (void)!write(holds_fd, "y", 1);
    } while (poll(&end, 1, 5) == 0);
    for (const auto& [publisher, chunk] : chunks) iox_pub_release_chunk(publisher, chunk);
    for (const iox_pub_t publisher : publishers) iox_pub_deinit(publisher);
    std::exit(0);  // signs off at the daemon
  }

  pid_t pid_ = 0;
  int leave_fd_ = -1;
};

/// Returns once a mapper has had this many scans of the mission that is played.
void wait_for_scans(int num_scans) {
  DdsOptions options;
  options.shared_memory = SharedMemoryUse::kOff;
  auto link = DdsLink::open(options);
  REQUIRE(link.has_value());
  auto topics = RobotTopics::open(*link);
  REQUIRE(topics.has_value());
  wait_for(*topics, [&](auto& values) { return values["scans_received"] >= num_scans; });
}

void set_loopback(bool is_up) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  request.ifr_flags = static_cast<short>(is_up ? IFF_UP | IFF_RUNNING : 0);
  REQUIRE(ioctl(fd, SIOCSIFFLAGS, &request) == 0);
  close(fd);
}

int count_of(const nlohmann::json& counts, const char* name) {
  return counts.contains(name) ? counts[name].get<int>() : 0;
}

TEST_CASE(
    "RouDi's memory is used up for a while: scans of that time are lost and counted at most, later "
    "ones are mapped") {
  Host host;
  if (!host.is_there()) return;
  Background roudi = host.roudi();
  Background run = host.run({kRoom, "dds.shared_memory=on"});
  Background play = host.play();
  wait_for_scans(20);
  {
    const Hog hog;
    std::this_thread::sleep_for(1s);
  }
  CHECK(play.wait() == 0);
  CHECK(run.end(SIGTERM) == 0);
  const auto summary = host.summary();
  const int read = summary["scans"]["read"].get<int>();
  // None at all where the publisher has a piece of memory left that its readers have done with.
  const int lost = count_of(summary["drops"], "scans_lost_on_the_way");
  CHECK(read + lost <= 150);
  CHECK(read >= 20);
  CHECK(summary["duration_s"].get<double>() > 10);
  CHECK(host.map_loads());
}

TEST_CASE("RouDi without memory for scans: who starts goes over UDP, or says why it cannot") {
  Host host;
  if (!host.is_there()) return;
  Background roudi = host.roudi();
  const Hog hog;
  {
    Background run = host.run({"dds.shared_memory=on"});
    CHECK(run.wait(60s) == 4);
    CHECK(read_text(host.log("run")).find("has no memory for samples") != std::string::npos);
  }
  Background run = host.run();
  Robot robot;
  const auto values = robot.map_first_scan();
  CHECK(values.at("shared_memory") == 0);
  CHECK(run.end(SIGTERM) == 0);
}

TEST_CASE("RouDi ended by SIGTERM ends the mapper, which saves its map") {
  Host host;
  if (!host.is_there()) return;
  Background roudi = host.roudi();
  Background run = host.run({kRoom, "dds.shared_memory=on"});
  Background play = host.play({"--rate", "2"});
  wait_for_scans(10);
  roudi.signal(SIGTERM);
  CHECK(run.wait() == 0);
  CHECK(host.summary()["interrupted"] == false);
  CHECK(host.summary()["scans"]["integrated"].get<int>() > 0);
  CHECK(host.map_loads());
}

TEST_CASE("a second mapper that stands still for seconds costs the first no scan") {
  for (const bool has_roudi : {false, true}) {
    CAPTURE(has_roudi);
    Host host;
    if (!host.is_there()) return;
    std::unique_ptr<Background> roudi;
    if (has_roudi) roudi = std::make_unique<Background>(host.roudi());
    Background run = host.run({kRoom});
    Background second({CLOISTER_PROGRAM, "run", "--out", (host.folder.path() / "second").string()},
                      host.log("second"));
    Background play = host.play({"--rate", "2"});
    wait_for_scans(20);
    second.signal(SIGSTOP);
    std::this_thread::sleep_for(3s);
    second.signal(SIGCONT);
    CHECK(play.wait() == 0);
    CHECK(read_text(host.log("play")) == "");
    CHECK(run.end(SIGTERM) == 0);
    CHECK(second.end(SIGTERM) == 0);
    const auto summary = host.summary();
    CHECK(count_of(summary["drops"], "scans_lost_on_the_way") == 0);
    CHECK(summary["scans"]["read"].get<int>() >= 149);
    const auto of_second = read_json(host.folder.path() / "second" / "summary.json");
    CHECK(of_second["scans"]["integrated"].get<int>() > 0);
  }
}

TEST_CASE("the sensor's cable is pulled and put back: mapping goes on where it stopped") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run(
      {kRoom, "sensor.source=udp", "sensor.metadata=" CLOISTER_HOUSE_MISSION "/metadata.json"});
  Background play = host.play({"--udp"});
  wait_for_scans(20);
  set_loopback(false);
  std::this_thread::sleep_for(1500ms);
  set_loopback(true);
  CHECK(play.wait() == 0);
  CHECK(run.end(SIGTERM) == 0);
  const auto summary = host.summary();
  const int read = summary["scans"]["read"].get<int>();
  CHECK(read > 20);
  CHECK(read < 145);
  CHECK(summary["scans"]["integrated"].get<int>() + summary["scans"]["dropped"].get<int>() == read);
  CHECK(summary["scans"]["integrated"].get<int>() > 20);
  // Up to the mission's last second.
  CHECK(summary["duration_s"].get<double>() > 13);
  CHECK(host.map_loads());
}

TEST_CASE("a sensor whose stamps are 100 ms behind those of odometry is put right by a setting") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run({"scan.stamp_offset_s=0.1"});
  Robot robot;
  // A metre a second: where the robot is tells the time.
  for (int ms = 0; ms <= 1000; ms += 10) robot.odometry(ms, ms, 1e-3 * ms);
  robot.scan(500);  // taken at 600
  robot.wait_for([](auto& values) { return values["scans_integrated"] == 1; });
  CHECK(run.end(SIGTERM) == 0);
  std::ifstream trajectory(host.out() / "trajectory.tum");
  for (std::string line; std::getline(trajectory, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream text(line);
    double stamp_s = 0, x_m = 0;
    text >> stamp_s >> x_m;
    CHECK(stamp_s == doctest::Approx(0.6).epsilon(1e-6));
    CHECK(x_m == doctest::Approx(0.6).epsilon(1e-6));
  }
}

TEST_CASE(
    "odometry that stops and comes back: scans between are dropped and counted, later ones are "
    "mapped") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run();
  Robot robot;
  robot.map_first_scan();
  for (int ms = 5000; ms < 5500; ms += 100) robot.scan(ms);
  robot.wait_for([](auto& values) { return values["drops.scan_without_pose"] == 5; });
  robot.odometry(8000, 9000);
  robot.scan(8500);
  robot.wait_for([](auto& values) { return values["scans_integrated"] == 2; });
  CHECK(run.end(SIGTERM) == 0);
  CHECK(host.summary()["scans"]["dropped"] == 5);
}

TEST_CASE("a graph that moves everything by metres takes the map along") {
  Host host;
  if (!host.is_there()) return;
  Background run = host.run();
  Robot robot;
  robot.odometry(0, 2000);
  robot.graph(graph(1, 600, {0, 1}));
  robot.scan(700);
  robot.wait_for([](auto& values) { return values["scans_integrated"] == 1; });
  GraphUpdate moved = graph(2, 800, {0, 1});
  for (GraphNode& node : moved.graph.nodes) node.T_M_N.translation().x() += 20;
  robot.graph(moved);
  robot.scan(900);
  robot.wait_for([](auto& values) {
    return values["scans_integrated"] == 2 && values["graph_revision"] == 2;
  });
  CHECK(run.end(SIGTERM) == 0);
  // All that is mapped, and the scan of before as well, lies about the new place.
  const auto submaps = read_json(host.out() / "submaps.json");
  std::ofstream(host.folder.path() / "points.csv") << "0,0,0\n1.5,0,0\n21.5,0,0\n";
  const auto queried =
      run_program(CLOISTER_PROGRAM, "query " + (host.out() / "map.cloister").string() + " " +
                                        (host.folder.path() / "points.csv").string());
  CAPTURE(queried.out);
  CAPTURE(submaps.dump());
  std::istringstream states(queried.out);
  std::vector<std::string> rows;
  for (std::string row; std::getline(states, row);) rows.push_back(row);
  REQUIRE(rows.size() >= 3);
  CHECK(rows[rows.size() - 2].find("unknown") != std::string::npos);
  CHECK(rows[rows.size() - 1].find("free") != std::string::npos);
}

TEST_CASE("a full disk loses nothing that is saved, is told, and a later save works") {
  Host host;
  if (!host.is_there()) return;
  fs::create_directory(host.out());
  REQUIRE(mount("tmpfs", host.out().c_str(), "tmpfs", 0, "size=8m") == 0);
  const fs::path map = host.out() / "map.cloister";
  const fs::path filler = host.out() / "filler";
  const auto fill_disk = [&] {
    std::ofstream file(filler, std::ios::binary);
    const std::string block(4096, 'x');
    while (file.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
  };
  Background run = host.run();
  Robot robot;
  robot.odometry(0, 3000);
  robot.scan(500);
  robot.wait_for([](auto& values) { return values["scans_integrated"] == 1; });
  REQUIRE(robot.save_map(1).is_saved);
  const std::string saved = read_text(map);

  fill_disk();
  robot.scan(1000);
  robot.wait_for([](auto& values) { return values["scans_integrated"] == 2; });
  const SaveMapReply refused = robot.save_map(2);
  CHECK_FALSE(refused.is_saved);
  CHECK(refused.message.find("map.cloister") != std::string::npos);
  CHECK(refused.message.find("No space left on device") != std::string::npos);
  CHECK(read_text(map) == saved);
  CHECK(host.map_loads());

  fs::remove(filler);
  CHECK(robot.save_map(3).is_saved);
  const std::string later = read_text(map);
  CHECK(later != saved);
  // Nothing half-written is left behind.
  CHECK(std::distance(fs::directory_iterator(host.out()), fs::directory_iterator()) == 1);

  fill_disk();
  robot.scan(1500);
  robot.wait_for([](auto& values) { return values["scans_integrated"] == 3; });
  CHECK(run.end(SIGTERM) == 4);
  CHECK(read_text(host.log("run")).find("No space left on device") != std::string::npos);
  CHECK(read_text(map) == later);
  CHECK(host.map_loads());
}

}  // namespace
}  // namespace cloister
