#include "job_order.h"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "fake_hooks.h"
#include "results.h"
#include "thread_pool.h"

namespace coppice::job_order_test {

std::uint64_t now = 0;

/// A job that writes its name down.
struct Named {
  std::string* ran;
  char name;

  static void run(void* argument) {
    const auto* job = static_cast<Named*>(argument);
    job->ran->push_back(job->name);
  }
};

/// A pool of one thread that knows no priorities: it runs jobs in the order of their submission, when the test says so.
class JobOrderTest : public testing::Test {
 protected:
  JobOrderTest() { now = 0; }
  ~JobOrderTest() override { EXPECT_EQ(allocator.live_bytes, 0u); }

  void submit(coppice_job_kind kind, char name) {
    const coppice_priority priority = kind == COPPICE_JOB_PIPELINE ? COPPICE_PRIORITY_LOW : COPPICE_PRIORITY_NORMAL;
    const coppice_job job = make_job(kind, priority, Named::run, &jobs.emplace_back(Named{&ran, name}));
    const coppice_jobs hook = order.hook();
    hook.submit(hook.user, &job);
  }
  void decode(char name) { submit(COPPICE_JOB_DECODE, name); }
  void pipeline(char name) { submit(COPPICE_JOB_PIPELINE, name); }

  std::deque<Named> jobs;
  std::string ran;
  test::FakeAllocator allocator;
  test::FakeJobs pool{.deferred = true};
  JobOrder order{pool.hook(), allocator.hook(), [] { return now; }};
};

TEST_F(JobOrderTest, DecodingOvertakesPipelinesThatThePoolHasAlready) {
  for (const char name : {'p', 'q', 'r'}) pipeline(name);
  pool.run_one();
  EXPECT_EQ(ran, "p") << "nothing decodes";
  decode('a');
  decode('b');
  pipeline('s');
  EXPECT_EQ(pool.waiting.size(), 4u) << "s is held back";
  pool.run_all();
  EXPECT_EQ(ran, "pabqrs");
}

TEST_F(JobOrderTest, JobsSayWhatTheyAre) {
  pipeline('p');
  decode('a');
  ASSERT_EQ(pool.waiting.size(), 2u);
  EXPECT_EQ(pool.waiting[0].struct_size, sizeof(coppice_job));
  EXPECT_EQ(pool.waiting[0].kind, COPPICE_JOB_PIPELINE);
  EXPECT_EQ(pool.waiting[0].priority, COPPICE_PRIORITY_LOW);
  EXPECT_EQ(pool.waiting[1].kind, COPPICE_JOB_DECODE);
  EXPECT_EQ(pool.waiting[1].priority, COPPICE_PRIORITY_NORMAL);
  pool.run_all();
}

TEST_F(JobOrderTest, APipelineBeginsEveryHalfASecondHoweverMuchIsDecoded) {
  for (const char name : {'p', 'q', 'r'}) pipeline(name);
  decode('a');
  std::vector<std::uint64_t> begun_ns;
  while (begun_ns.size() < 3 && now < 20 * JobOrder::kMaxHeldNs) {
    now += JobOrder::kMaxHeldNs / 8;
    decode('a');  // as many as are run, so that one always waits
    order.release_overdue();
    pool.run_one();
    if (!ran.empty() && ran.back() != 'a' && ran.size() > begun_ns.size()) begun_ns.push_back(now);
    std::erase(ran, 'a');
  }
  EXPECT_EQ(ran, "pqr");
  ASSERT_EQ(begun_ns.size(), 3u);
  EXPECT_GE(begun_ns[0], JobOrder::kMaxHeldNs);
  EXPECT_GE(begun_ns[1], begun_ns[0] + JobOrder::kMaxHeldNs);
  EXPECT_GE(begun_ns[2], begun_ns[1] + JobOrder::kMaxHeldNs);
  pool.run_all();
}

TEST_F(JobOrderTest, WithoutMemoryJobsGoToThePoolAsTheyAre) {
  allocator.fail_at = 0;
  allocator.fail_for_good = true;
  pipeline('p');
  decode('a');
  pool.run_all();
  EXPECT_EQ(ran, "pa");
}

// ThreadSanitizer looks at this one.
TEST(JobOrder, RunsEverythingOnceOnManyThreads) {
  test::FakeAllocator allocator;
  std::atomic<int> ran = 0;
  {
    std::unique_ptr<ThreadPool> pool = test::must(ThreadPool::create(3));
    const coppice_jobs hook{sizeof(coppice_jobs), pool.get(), [](void* user, const coppice_job* job) {
                              static_cast<ThreadPool*>(user)->submit(job->function, job->argument);
                            }};
    JobOrder order(hook, allocator.hook(), [] { return std::uint64_t{1}; });
    const coppice_jobs ordered = order.hook();
    for (int i = 0; i < 3000; ++i) {
      const coppice_job job = make_job(
          i % 3 == 0 ? COPPICE_JOB_DECODE : COPPICE_JOB_PIPELINE, COPPICE_PRIORITY_NORMAL,
          [](void* argument) { ++*static_cast<std::atomic<int>*>(argument); }, &ran);
      ordered.submit(ordered.user, &job);
      if (i % 7 == 0) order.release_overdue();
    }
    while (ran < 3000) std::this_thread::yield();
    pool.reset();
  }
  EXPECT_EQ(ran, 3000);
  EXPECT_EQ(allocator.live_bytes, 0u);
}

}  // namespace coppice::job_order_test
