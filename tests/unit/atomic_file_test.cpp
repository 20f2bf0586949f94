#include "atomic_file.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;

/// A folder of its own for each test, gone afterwards.
class AtomicFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "coppice_atomic_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::size_t file_count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

std::vector<std::uint8_t> filled(std::size_t byte_count, std::uint8_t value) {
  return std::vector<std::uint8_t>(byte_count, value);
}

TEST_F(AtomicFile, ReadsBackWhatWasWrittenAndLeavesNothingElse) {
  for (const std::size_t byte_count : {std::size_t{0}, std::size_t{1}, std::size_t{65536}, std::size_t{1000003}}) {
    ASSERT_TRUE(write_file_atomically(folder_ / "plant.glb", filled(byte_count, 7)));
    const auto bytes = read_file(folder_ / "plant.glb");
    ASSERT_TRUE(bytes);
    EXPECT_EQ(*bytes, filled(byte_count, 7));
    EXPECT_EQ(file_count(), 1u);
  }
}

TEST_F(AtomicFile, MissingFolderIsNamedWithTheReason) {
  const auto result = write_file_atomically(folder_ / "none" / "plant.glb", filled(3, 1));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().status, Status::io);
  EXPECT_NE(result.error().message().find("none/plant.glb: No such file or directory"), std::string::npos) << result.error().message();
}

TEST_F(AtomicFile, FolderAndDeviceAreNeverReplaced) {
  EXPECT_FALSE(write_file_atomically(folder_, filled(3, 1)));
  EXPECT_TRUE(fs::is_directory(folder_));
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  EXPECT_FALSE(write_file_atomically(folder_ / "pipe", filled(3, 1)));
  EXPECT_TRUE(fs::is_fifo(folder_ / "pipe"));
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(AtomicFile, SymbolicLinkIsFollowed) {
  ASSERT_TRUE(write_file_atomically(folder_ / "target", filled(3, 1)));
  fs::create_symlink("target", folder_ / "link");
  ASSERT_TRUE(write_file_atomically(folder_ / "link", filled(5, 2)));
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(*read_file(folder_ / "target"), filled(5, 2));
}

TEST_F(AtomicFile, ReadingAMissingFileOrAFolderFails) {
  EXPECT_EQ(read_file(folder_ / "none").error().status, Status::io);
  EXPECT_EQ(read_file(folder_).error().status, Status::io);
}

TEST_F(AtomicFile, ReadingStopsWhereItIsTold) {
  ASSERT_TRUE(write_file_atomically(folder_ / "long", filled(200000, 3)));
  EXPECT_EQ(*read_file(folder_ / "long", 70000), filled(70000, 3));
  EXPECT_EQ(*read_file(folder_ / "long", 0), filled(0, 3));
  EXPECT_EQ(*read_file(folder_ / "long", 200000), filled(200000, 3));
  EXPECT_EQ(*read_file(folder_ / "long", 300000), filled(200000, 3));
  fs::resize_file(folder_ / "long", std::uintmax_t{20} << 30);
  EXPECT_EQ(*read_file(folder_ / "long", 70000), filled(70000, 3));
}

// A write that fails half way (here: the process's file size limit, like a full disk) leaves the old file and no temporary one.
TEST_F(AtomicFile, FailedWriteKeepsTheOldFile) {
  ASSERT_TRUE(write_file_atomically(folder_ / "plant.glb", filled(100, 1)));
  const pid_t child = ::fork();
  if (child == 0) {
    if (std::signal(SIGXFSZ, SIG_IGN) == SIG_ERR) ::_exit(9);
    const rlimit limit{4096, 4096};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    ::_exit(write_file_atomically(folder_ / "plant.glb", filled(100000, 2)) ? 1 : 0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "the write was expected to fail";
  EXPECT_EQ(*read_file(folder_ / "plant.glb"), filled(100, 1));
  EXPECT_EQ(file_count(), 1u);
}

// Kills a process that rewrites one file without pause, at many different moments: what is there is always one whole version.
TEST_F(AtomicFile, KilledWriterLeavesAWholeFile) {
  constexpr std::size_t kBytes = 1 << 20;
  ASSERT_TRUE(write_file_atomically(folder_ / "plant.glb", filled(kBytes, 0)));
  for (int round = 0; round < 20; ++round) {
    const pid_t child = ::fork();
    if (child == 0) {
      for (std::uint8_t value = 1;; value = static_cast<std::uint8_t>(value % 250 + 1))
        if (!write_file_atomically(folder_ / "plant.glb", filled(kBytes, value))) ::_exit(1);
    }
    std::this_thread::sleep_for(std::chrono::microseconds(2000 + 731 * round));
    ::kill(child, SIGKILL);
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    const auto bytes = read_file(folder_ / "plant.glb");
    ASSERT_TRUE(bytes);
    ASSERT_EQ(bytes->size(), kBytes);
    EXPECT_EQ(std::ranges::count(*bytes, bytes->front()), static_cast<std::ptrdiff_t>(kBytes));
  }
}

TEST_F(AtomicFile, WhatADeadProcessLeftIsRemovedAndNothingElse) {
  const pid_t dead = ::fork();
  if (dead == 0) ::_exit(0);
  ASSERT_EQ(::waitpid(dead, nullptr, 0), dead);
  const std::string number = std::to_string(dead);
  const std::vector<std::string> kept = {".oak.coppice." + std::to_string(::getpid()) + ".0.tmp",  // being written
                                         "oak.coppice",
                                         "oak." + number + ".0.tmp",
                                         ".oak.coppice." + number + ".0",
                                         ".oak.tmp",
                                         ".tmp",
                                         ".oak.coppice.12a.0.tmp"};
  for (const std::string& name : kept) ASSERT_TRUE(write_file_atomically(folder_ / name, filled(3, 1))) << name;
  ASSERT_TRUE(write_file_atomically(folder_ / (".oak.coppice." + number + ".0.tmp"), filled(3, 1)));
  remove_abandoned_temporaries(folder_);
  for (const std::string& name : kept) EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  EXPECT_EQ(file_count(), kept.size());
  remove_abandoned_temporaries(folder_ / "nowhere");
}

}  // namespace
}  // namespace coppice::bake
