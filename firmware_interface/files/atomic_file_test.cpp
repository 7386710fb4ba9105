#include "firmware_interface/files/atomic_file.hpp"

#include <array>
#include <filesystem>
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "firmware_interface/files/read_file.hpp"
#include "firmware_interface/files/test_files.hpp"

namespace cloister {
namespace {

std::size_t count_files(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST_CASE("a committed file holds all its bytes and leaves no other behind") {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "out.bin";
  std::string expected;
  auto file = AtomicFile::open(path);
  REQUIRE(file);
  for (int k = 0; k < 3000; ++k) {
    const std::string part(static_cast<std::size_t>(k) % 700, static_cast<char>('a' + k % 26));
    REQUIRE(file->write(part));
    expected += part;
  }
  const std::array<std::byte, 3> bytes = {std::byte{0}, std::byte{255}, std::byte{7}};
  REQUIRE(file->write(bytes));
  expected += std::string("\0\xff\x07", 3);
  CHECK_FALSE(std::filesystem::exists(path));
  REQUIRE(file->commit());
  CHECK(*read_file(path) == expected);
  CHECK(count_files(folder.path()) == 1);
  CHECK_FALSE(file->write("more"));
  CHECK_FALSE(file->commit());
}

TEST_CASE("without a commit the former file stays and the temporary one goes") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("out.txt", "former");
  {
    auto file = AtomicFile::open(path);
    REQUIRE(file);
    REQUIRE(file->write(std::string(1 << 20, 'x')));
    AtomicFile moved = std::move(*file);
    REQUIRE(moved.write("y"));
    CHECK(*read_file(path) == "former");
    CHECK(count_files(folder.path()) == 2);
  }
  CHECK(*read_file(path) == "former");
  CHECK(count_files(folder.path()) == 1);
  REQUIRE(write_file_atomically(path, "newer"));
  CHECK(*read_file(path) == "newer");
}

TEST_CASE("a place that cannot be written fails as a resource and names the path") {
  const test::TemporaryFolder folder;
  const auto missing = AtomicFile::open(folder.path() / "missing" / "out.txt");
  REQUIRE_FALSE(missing);
  CHECK(missing.error().kind == ErrorKind::kResource);
  CHECK(test::contains(missing.error().message, "missing/out.txt: cannot be created"));

  std::filesystem::create_directory(folder.path() / "taken");
  const auto taken = write_file_atomically(folder.path() / "taken", "text");
  REQUIRE_FALSE(taken);
  CHECK(taken.error().kind == ErrorKind::kResource);
  CHECK(test::contains(taken.error().message, "taken: cannot take its name"));
  CHECK(count_files(folder.path()) == 1);
}

TEST_CASE("reading what is no file is an input failure that names it") {
  const test::TemporaryFolder folder;
  CHECK(read_file(folder.path()).error().kind == ErrorKind::kInput);
  CHECK(test::contains(read_file(folder.path()).error().message, folder.path().string()));
  CHECK(test::contains(read_file(folder.path() / "none").error().message, "none: cannot be read"));
  CHECK(read_file(folder.write("empty"))->empty());
}

}  // namespace
}  // namespace cloister
