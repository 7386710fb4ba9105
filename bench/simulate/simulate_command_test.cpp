#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <doctest/doctest.h>
#include <sys/wait.h>

namespace {

namespace fs = std::filesystem;

/// A directory of its own for one test, removed afterwards.
class Scratch {
 public:
  Scratch()
      : path_(fs::temp_directory_path() / ("cloister-simulate-test-" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() { fs::remove_all(path_); }
  [[nodiscard]] fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

std::string read(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

int simulate(const std::string& arguments, const fs::path& error = "/dev/null") {
  const std::string command =
      std::string(CLOISTER_SIMULATE_PROGRAM) + " " + arguments + " > /dev/null 2> " + error.string();
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

const std::string kFewScans = " --minutes 0.004 --columns 512";  // two scans

TEST_CASE(
    "the same seed gives the same bytes on any number of threads, another seed gives others") {
  const Scratch scratch;
  REQUIRE(simulate("house --seed 5 --threads 1 --out " + (scratch / "a").string() + kFewScans) ==
          0);
  REQUIRE(simulate("house --seed 5 --threads 4 --out " + (scratch / "b").string() + kFewScans) ==
          0);
  REQUIRE(simulate("house --seed 6 --out " + (scratch / "c").string() + kFewScans) == 0);
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(scratch / "a")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    const fs::path name = fs::relative(entry.path(), scratch / "a");
    CAPTURE(name.string());
    CHECK(read(entry.path()) == read(scratch / "b" / name));
  }
  CHECK(files >= 8);
  CHECK(read(scratch / "a" / "lidar.pcap") != read(scratch / "c" / "lidar.pcap"));
  // Two revolutions of 32 packets: nine fragments each, with record, Ethernet and IPv4 headers.
  CHECK(fs::file_size(scratch / "a" / "lidar.pcap") == 24 + 2 * 32 * (12'616 + 9 * (16 + 14 + 20)));
}

TEST_CASE("the campus is recorded by an OS1-64, from any minute of its path") {
  const Scratch scratch;
  REQUIRE(simulate("campus --out " + (scratch / "a").string() + kFewScans) == 0);
  REQUIRE(simulate("campus --skip 20 --out " + (scratch / "b").string() + kFewScans) == 0);
  CHECK(read(scratch / "a" / "metadata.json").find("OS-1-64") != std::string::npos);
  CHECK(read(scratch / "a" / "ground_truth" / "rooms.json").find("tunnel") != std::string::npos);
  CHECK(read(scratch / "a" / "ground_truth" / "trajectory.tum") !=
        read(scratch / "b" / "ground_truth" / "trajectory.tum"));
}

TEST_CASE("a mission is replaced by a new one, any other directory is left alone") {
  const Scratch scratch;
  const std::string out = " --out " + (scratch / "m").string() + kFewScans;
  REQUIRE(simulate("house --seed 1" + out) == 0);
  const std::string first = read(scratch / "m" / "lidar.pcap");
  REQUIRE(simulate("house --seed 2" + out) == 0);
  CHECK(read(scratch / "m" / "lidar.pcap") != first);

  fs::create_directories(scratch / "thesis");
  std::ofstream(scratch / "thesis" / "chapter.txt") << "precious";
  CHECK(simulate("house --out " + (scratch / "thesis").string() + kFewScans, scratch / "error") ==
        2);
  CHECK(read(scratch / "thesis" / "chapter.txt") == "precious");
  CHECK(read(scratch / "error").find("thesis") != std::string::npos);
  int entries = 0;
  for (const auto& entry : fs::directory_iterator(scratch / ".")) entries += entry.exists() ? 1 : 0;
  CHECK(entries == 3);  // nothing half-written stays behind
}

TEST_CASE("a mesh with a path is a world too") {
  const Scratch scratch;
  REQUIRE(simulate("house --out " + (scratch / "house").string() + kFewScans) == 0);
  std::ofstream(scratch / "path.txt") << "5.5 1.5 1.1\n5.5 8.0 1.1\n";
  CHECK(simulate((scratch / "house/ground_truth/mesh.ply").string() + " --path " +
                 (scratch / "path.txt").string() + " --sensor os1-64 --out " +
                 (scratch / "mesh").string() + kFewScans) == 0);
  CHECK(fs::exists(scratch / "mesh" / "pose_graph"));
  CHECK(read(scratch / "mesh" / "ground_truth" / "rooms.json") == "[]\n");
}

TEST_CASE("each kind of mistake has its exit status and one line that names it") {
  const Scratch scratch;
  const std::string out = " --out " + (scratch / "m").string();
  std::ofstream(scratch / "bad.ply") << "ply\nformat ascii 1.0\nelement vertex many\n";
  std::ofstream(scratch / "path.txt") << "0 0 1\n0 zero 1\n";
  const std::string bad_ply = (scratch / "bad.ply").string();
  const struct {
    std::string arguments;
    int status;
    std::string named;
  } cases[] = {
      {"", 2, "WORLD"},
      {"house", 2, "--out"},
      {"house --sensor os7" + out, 2, "os7"},
      {"house --minutes -1" + out, 2, "--minutes"},
      {"house --columns 2048 --rate 20" + out, 2, "2048"},
      {"house --bogus" + out, 2, "--bogus"},
      {"house --skip 90" + out, 2, "--skip"},
      {"house --wrong-closures 0.7" + out, 2, "--wrong-closures"},
      {"house --clouds some" + out, 2, "--clouds"},
      {"house --clouds scans" + out + kFewScans, 2, "--clouds"},
      {"castle" + out, 3, "castle"},
      {bad_ply + out, 2, "--path"},
      {bad_ply + " --path " + (scratch / "path.txt").string() + out, 3, "bad.ply:3:"},
      {"house --path " + (scratch / "path.txt").string() + out, 3, "path.txt:2:"},
      {"house --path " + (scratch / "none.txt").string() + out, 3, "none.txt"},
      {"house --out /proc/cloister" + kFewScans, 4, "/proc"},
  };
  for (const auto& c : cases) {
    CAPTURE(c.arguments);
    CHECK(simulate(c.arguments, scratch / "error") == c.status);
    const std::string error = read(scratch / "error");
    CAPTURE(error);
    CHECK(error.find(c.named) != std::string::npos);
    CHECK(std::count(error.begin(), error.end(), '\n') == 1);
    CHECK_FALSE(fs::exists(scratch / "m"));
  }
  CHECK(simulate("--help") == 0);
}

}  // namespace
