#include "server/compute/worker_pool.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <thread>
#include <vector>

namespace zoned::compute {
namespace {

TEST(WorkerPool, RunsEachTaskOnce) {
    for (const unsigned threads : {1U, 2U, 5U}) {
        WorkerPool pool(threads);
        for (const std::size_t count : {0U, 1U, 2U, 7U, 1000U}) {
            std::vector<std::atomic<int>> runs(count);
            pool.run(count, [&](std::size_t i) { runs[i].fetch_add(1); });
            for (const auto& r : runs) {
                EXPECT_EQ(r.load(), 1);
            }
        }
    }
}

TEST(WorkerPool, HasSeenAllThatTasksWroteWhenItReturns) {
    WorkerPool pool(3);
    std::vector<std::uint64_t> values(64);
    for (std::uint64_t round = 1; round <= 2000; ++round) {
        pool.run(values.size(), [&](std::size_t i) { values[i] += round; });
    }
    for (const std::uint64_t value : values) {
        EXPECT_EQ(value, 2000U * 2001U / 2U);
    }
}

/// Otherwise nothing could report that a zone's step has filled the stack of its thread.
TEST(WorkerPool, ThreadsHaveAStackForSignals) {
    WorkerPool pool(2);
    std::atomic<int> own_threads{0};
    std::atomic<int> with_stack{0};
    const std::thread::id caller = std::this_thread::get_id();
    for (int round = 0; round < 10000 && own_threads.load() == 0; ++round) {
        pool.run(2, [&](std::size_t) {
            if (std::this_thread::get_id() != caller) {
                stack_t stack{};
                ::sigaltstack(nullptr, &stack);
                with_stack.fetch_add((stack.ss_flags & SS_DISABLE) == 0 ? 1 : 0);
                own_threads.fetch_add(1);
            }
            std::this_thread::sleep_for(std::chrono::microseconds(100));
        });
    }
    EXPECT_GT(own_threads.load(), 0);
    EXPECT_EQ(with_stack.load(), own_threads.load());
}

TEST(WorkerPool, CountsTheTimeOfItsOwnThreadsOnly) {
    WorkerPool alone(1);
    std::atomic<std::uint64_t> sum{0};
    const auto burn = [&](std::size_t i) {
        std::uint64_t x = i;
        for (int k = 0; k < 2'000'000; ++k) {
            x = x * 6364136223846793005ULL + 1442695040888963407ULL;
        }
        sum += x;
    };
    alone.run(4, burn);
    EXPECT_EQ(alone.cpu_ns(), 0U);
}

/// Sums in blocks, on any available threads.
std::uint64_t sum_of(Team& team, const std::vector<std::uint32_t>& values) {
    std::atomic<std::uint64_t> sum{0};
    team.run(values.size(), 16, [&](std::size_t begin, std::size_t end) {
        sum += std::accumulate(values.begin() + static_cast<std::ptrdiff_t>(begin),
                               values.begin() + static_cast<std::ptrdiff_t>(end),
                               std::uint64_t{0});
    });
    return sum;
}

TEST(Team, CoversEachRangeOnceWithAndWithoutHelpers) {
    std::vector<std::uint32_t> values(1003);
    std::iota(values.begin(), values.end(), 1U);
    const std::uint64_t expected = 1003U * 1004U / 2U;
    Team nobody;
    EXPECT_EQ(sum_of(nobody, values), expected);
    WorkerPool pool(4);
    Team team;
    team.join_pool(pool);
    EXPECT_EQ(sum_of(team, values), expected);  // between shifts
    const Team::Shift shift(team);
    for (int stage = 0; stage < 5000; ++stage) {
        ASSERT_EQ(sum_of(team, values), expected);
    }
}

/// Each stage reads all results of the stage before: a thread that sees old values is found.
TEST(Team, SeesInEachStageWhatTheStagesBeforeWrote) {
    WorkerPool pool(4);
    Team team;
    team.join_pool(pool);
    std::vector<std::uint32_t> even(256, 1);
    std::vector<std::uint32_t> odd(256, 0);
    const Team::Shift shift(team);
    for (int stage = 0; stage < 4000; ++stage) {
        auto& from = stage % 2 == 0 ? even : odd;
        auto& to = stage % 2 == 0 ? odd : even;
        team.run(256, 8, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                to[i] = from[255 - i] + 1;
            }
        });
    }
    for (const std::uint32_t value : even) {
        EXPECT_EQ(value, 4001U);
    }
}

TEST(Team, IsLedFromWithinTheTasksOfABatch) {
    WorkerPool pool(3);
    std::vector<Team> teams(5);
    std::vector<std::uint64_t> sums(5);
    for (Team& team : teams) {
        team.join_pool(pool);
    }
    std::vector<std::uint32_t> values(500, 3);
    for (int round = 0; round < 200; ++round) {
        pool.run(5, [&](std::size_t i) {
            const Team::Shift shift(teams[i]);
            for (int stage = 0; stage < 10; ++stage) {
                sums[i] += sum_of(teams[i], values);
            }
        });
    }
    for (const std::uint64_t sum : sums) {
        EXPECT_EQ(sum, 200U * 10U * 1500U);
    }
}

TEST(Team, DoesAllAloneWhenTheBoardIsFull) {
    WorkerPool pool(2);
    std::vector<Team> teams(70);
    std::vector<std::unique_ptr<Team::Shift>> shifts;
    std::vector<std::uint32_t> values(100, 1);
    for (Team& team : teams) {
        team.join_pool(pool);
        shifts.push_back(std::make_unique<Team::Shift>(team));
    }
    for (Team& team : teams) {
        EXPECT_EQ(sum_of(team, values), 100U);
    }
}

}  // namespace
}  // namespace zoned::compute
