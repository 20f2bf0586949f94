#include "atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <string>
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "process.h"
#include "results.h"
#include "temporary_file.h"

namespace coppice::bake::atomic_file_test {

namespace fs = std::filesystem;

/// A folder of its own for each test, gone afterwards.
class AtomicFile : public testing::Test {
 protected:
  [[nodiscard]] std::size_t file_count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  test::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
};

std::vector<std::uint8_t> filled(std::size_t byte_count, std::uint8_t value) {
  return std::vector<std::uint8_t>(byte_count, value);
}

TEST_F(AtomicFile, ReadsBackWhatWasWrittenAndLeavesNothingElse) {
  for (const std::size_t byte_count : {std::size_t{0}, std::size_t{1}, std::size_t{65536}, std::size_t{1000003}}) {
    ASSERT_TRUE(write_file_atomically(folder_ / "plant.glb", filled(byte_count, 7)));
    const auto bytes = test::must(read_file(folder_ / "plant.glb"));
    EXPECT_EQ(bytes, filled(byte_count, 7));
    EXPECT_EQ(file_count(), 1u);
  }
}

TEST_F(AtomicFile, MissingFolderIsNamedWithTheReason) {
  test::expect_error(write_file_atomically(folder_ / "none" / "plant.glb", filled(3, 1)), Status::io,
                     {"none/plant.glb", std::strerror(ENOENT)});
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

/// A folder that everybody writes to, with a file and a folder of the user's, and links to both that another user made.
class SharedFolder : public AtomicFile {
 protected:
  static constexpr uid_t kOther = 4711;

  void SetUp() override {
    if (::geteuid() != 0) GTEST_SKIP() << "only root can act for another user";
    fs::create_directory(shared_);
    fs::permissions(shared_, fs::perms::all);
    fs::create_directory(folder_ / "mine");
    ASSERT_TRUE(write_file_atomically(mine_, filled(3, 1)));
    for (const auto& [name, target] : {std::pair{"link", mine_}, std::pair{"folder", folder_ / "mine"}}) {
      fs::create_symlink(target, shared_ / name);
      ASSERT_EQ(::lchown((shared_ / name).c_str(), kOther, kOther), 0);
    }
  }

  fs::path shared_ = folder_ / "shared", mine_ = folder_ / "mine" / "file";
};

TEST_F(SharedFolder, NoLinkOfAnotherUserIsFollowed) {
  const fs::path link = shared_ / "link", below = shared_ / "folder" / "file";
  EXPECT_TRUE(try_writing(link));
  ASSERT_TRUE(write_file_atomically(link, filled(5, 2)));
  EXPECT_FALSE(fs::is_symlink(link)) << "it is replaced";
  EXPECT_EQ(*read_file(link), filled(5, 2));
  for (const auto& result : {write_file_atomically(below, filled(5, 2)), try_writing(below), make_folder_of(below)})
    test::expect_error(result, Status::io, {below.string(), "folder"});
  EXPECT_EQ(*read_file(mine_), filled(3, 1));
  fs::permissions(shared_, fs::perms::owner_all);
  EXPECT_TRUE(write_file_atomically(below, filled(7, 3))) << "nobody but the folder's owner can have put it there";
  EXPECT_EQ(*read_file(mine_), filled(7, 3));
}

TEST_F(SharedFolder, AStickyFolderKeepsOthersFilesAndThatIsToldBeforeTheWork) {
  fs::permissions(shared_, fs::perms::all | fs::perms::sticky_bit);
  fs::permissions(folder_, fs::perms::all);
  ASSERT_TRUE(write_file_atomically(shared_ / "roots", filled(3, 1)));
  const pid_t child = ::fork();
  if (child == 0) {
    if (::setuid(kOther) != 0) ::_exit(9);
    ::_exit(write_file_atomically(shared_ / "new", filled(1, 1)) && !try_writing(shared_ / "roots") ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

TEST_F(SharedFolder, WhatAnotherUserMadeProvesNothing) {
  const fs::path theirs = shared_ / "theirs";
  ASSERT_TRUE(write_file_atomically(theirs, filled(3, 1)));
  EXPECT_TRUE(read_kept_file(theirs, FileOwner::user));
  ASSERT_EQ(::chown(theirs.c_str(), kOther, kOther), 0);
  EXPECT_TRUE(read_kept_file(theirs, FileOwner::anybody));
  test::expect_error(read_kept_file(theirs, FileOwner::user), Status::bad_file, {theirs.string()});
}

TEST_F(AtomicFile, LinksAndPipesAreNotWhatWasKept) {
  ASSERT_TRUE(write_file_atomically(folder_ / "kept", filled(3, 1)));
  fs::create_symlink("kept", folder_ / "link");
  fs::create_symlink("nothing", folder_ / "lock");
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(*read_kept_file(folder_ / "kept", FileOwner::user, 2), filled(2, 1));
  for (const char* name : {"link", "pipe"})
    test::expect_error(read_kept_file(folder_ / name, FileOwner::anybody), Status::bad_file, {(folder_ / name).string()});
  EXPECT_FALSE(lock_file(folder_ / "lock", LockKind::alone, ""));
  EXPECT_FALSE(fs::exists(folder_ / "nothing"));
}

TEST_F(AtomicFile, APlaceStaysInTheFolderThatWasFound) {
  const fs::path cache = folder_ / "cache", moved = folder_ / "moved";
  fs::create_directory(cache);
  ASSERT_TRUE(write_file_atomically(cache / "b", filled(2, 1)));
  const FilePlace a = test::must(find_place(cache / "a", LastLink::stays)), b = test::must(beside(a, "b"));
  fs::rename(cache, moved);
  fs::create_directory(cache);
  ASSERT_TRUE(write_file_atomically(cache / "b", filled(2, 2)));
  EXPECT_EQ(test::must(read_kept_file(b, FileOwner::user)), filled(2, 1));
  ASSERT_TRUE(write_file_atomically(a, filled(2, 3)));
  EXPECT_EQ(test::must(read_file(moved / "a")), filled(2, 3));
  EXPECT_FALSE(fs::exists(cache / "a"));
}

TEST_F(AtomicFile, LinksThatLeadInACircleOrNowhereAreErrors) {
  fs::create_symlink("circle", folder_ / "circle");
  fs::create_symlink("/", folder_ / "root");
  for (const fs::path& path : {folder_ / "circle", folder_ / "circle" / "x", folder_ / "root"})
    EXPECT_FALSE(write_file_atomically(path, {}));
  fs::create_directory_symlink(folder_, folder_ / "self");
  ASSERT_TRUE(write_file_atomically(folder_ / "self" / "self" / "x", filled(3, 1)));
  EXPECT_TRUE(fs::is_regular_file(folder_ / "x"));
}

TEST_F(AtomicFile, ReadingAnythingButAFileFailsAtOnceWithTheReason) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", folder_ / "zero");
  const std::pair<const char*, std::string> cases[] = {
      {"none", std::strerror(ENOENT)}, {"", std::strerror(EISDIR)}, {"pipe", "pipe"}, {"zero", "zero"}};
  for (const auto& [name, reason] : cases) test::expect_error(read_file(folder_ / name), Status::io, {(folder_ / name).string(), reason});
}

TEST_F(AtomicFile, TheFrontOfAFileIsReadAlone) {
  const fs::path path = folder_ / "buffer.bin";
  ASSERT_TRUE(write_file_atomically(path, filled(200000, 7)));
  for (const std::size_t bytes : {0u, 36u, 70000u, 200000u}) EXPECT_EQ(*read_file(path, bytes), filled(bytes, 7));
  EXPECT_EQ(*read_file(path, 300000), filled(200000, 7));
  fs::resize_file(path, std::uintmax_t{1} << 43);  // 8 TB that are not there, but for the front
  for (const std::size_t bytes : {36u, 70000u}) EXPECT_EQ(*read_file(path, bytes), filled(bytes, 7));
}

TEST_F(AtomicFile, TryingToWriteChangesNothingAndFindsWhatWouldFail) {
  EXPECT_TRUE(try_writing(folder_ / "new.coppice"));
  EXPECT_EQ(file_count(), 0u);
  ASSERT_TRUE(write_file_atomically(folder_ / "old.coppice", filled(3, 1)));
  EXPECT_TRUE(try_writing(folder_ / "old.coppice"));
  EXPECT_EQ(*read_file(folder_ / "old.coppice"), filled(3, 1));
  const std::pair<fs::path, std::string> cases[] = {{"", ":"},
                                                    {folder_, std::strerror(EISDIR)},
                                                    {folder_ / "new/", std::strerror(EISDIR)},
                                                    {folder_ / "none" / "x", std::strerror(ENOENT)},
                                                    {folder_ / "old.coppice" / "x", std::strerror(ENOTDIR)},
                                                    {folder_ / std::string(256, 'n'), std::strerror(ENAMETOOLONG)},
                                                    {"/dev/full", "/dev/full"},
                                                    {"/proc/x", "/proc/x"}};
  for (const auto& [path, reason] : cases) {
    test::expect_error(try_writing(path), Status::io, {reason});
    EXPECT_FALSE(write_file_atomically(path, filled(3, 1))) << path;
  }
  EXPECT_TRUE(try_writing("/dev/null"));
  EXPECT_TRUE(write_file_atomically("/dev/null", filled(3, 1)));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_TRUE(write_file_atomically(folder_ / std::string(255, 'n'), filled(3, 1))) << "as long as a name may be";
  EXPECT_EQ(file_count(), 2u);
}

TEST_F(AtomicFile, ASignalRemovesTheTemporaryFileOfItsOwnProcess) {
  auto of_parent = test::must(TemporaryFile::create_beside(test::must(find_place(folder_ / "parent"))));
  const pid_t child = ::fork();
  if (child == 0) {
    auto file = TemporaryFile::create_beside(test::must(find_place(folder_ / "child")));
    if (!file || std::signal(SIGTERM, end_by_signal) == SIG_ERR) ::_exit(9);
    static_cast<void>(std::raise(SIGTERM));
    ::_exit(8);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM);
  EXPECT_EQ(file_count(), 1u) << "the parent's stays, the child's goes";
  ASSERT_TRUE(of_parent.publish());
  EXPECT_TRUE(fs::exists(folder_ / "parent"));
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
    const auto bytes = test::must(read_file(folder_ / "plant.glb"));
    ASSERT_EQ(bytes.size(), kBytes);
    EXPECT_EQ(std::ranges::count(bytes, bytes.front()), static_cast<std::ptrdiff_t>(kBytes));
  }
}

TEST_F(AtomicFile, WhatADeadProcessLeftIsRemovedAndNothingElse) {
  const pid_t dead = ::fork();
  if (dead == 0) ::_exit(0);
  ASSERT_EQ(::waitpid(dead, nullptr, 0), dead);
  const std::string number = std::to_string(dead);
  const std::vector<std::string> kept = {".coppice-" + std::to_string(::getpid()) + "-0.tmp",  // being written
                                         "oak.coppice",
                                         "coppice-" + number + "-0.tmp",
                                         ".oak-" + number + "-0.tmp",
                                         ".coppice-" + number + "-0",
                                         ".coppice-" + number + ".tmp",
                                         ".coppice-.tmp",
                                         ".coppice-12a-0.tmp",
                                         ".coppice-" + number + "-7.tmp"};
  for (const std::string& name : kept) ASSERT_TRUE(write_file_atomically(folder_ / name, filled(3, 1))) << name;
  // One that somebody holds, whose process has a number in another container only.
  const int held = ::open((folder_ / kept.back()).c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(::flock(held, LOCK_EX), 0);
  ASSERT_TRUE(write_file_atomically(folder_ / (".coppice-" + number + "-0.tmp"), filled(3, 1)));
  remove_abandoned_temporaries(folder_);
  ::close(held);
  for (const std::string& name : kept) EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  EXPECT_EQ(file_count(), kept.size());
  remove_abandoned_temporaries(folder_ / "nowhere");
}

}  // namespace coppice::bake::atomic_file_test
