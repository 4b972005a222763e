#include "tests/bench/report/scene_runs.h"

#include "tests/bench/report/results_reader.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cstdio>
#include <stdexcept>

namespace zoned::bench {
namespace {

/// Two suites of two scenes each, whose runs are counted and may fail.
struct Fake {
    std::vector<std::string> ran;
    std::string fails_at;
    std::vector<Suite> suites;

    Fake() {
        for (const char* name : {"p", "q"}) {
            suites.push_back({name, "", {"a", "b"}, {"default"}, [this, name](Session& s) {
                                  run(name, s);
                              }});
        }
    }

    void run(const std::string& suite, Session& session) {
        for (const char* scene : {"a", "b"}) {
            if (!session.wants_scene(scene)) {
                continue;
            }
            ran.push_back(suite + scene);
            if (fails_at == suite + scene) {
                throw std::runtime_error("interrupted");
            }
            Row row;
            row.suite = suite;
            row.scene = scene;
            session.add({row, row});
        }
    }
};

std::string scratch(const char* name) {
    return testing::TempDir() + std::to_string(getpid()) + name;
}

SceneHooks keeping(const std::string& file) {
    SceneHooks hooks;
    hooks.after = [file](const Results& results) {
        write_text_file(file, to_json(results, Pictures::kKeep));
    };
    return hooks;
}

TEST(SceneRuns, GoOnWhereTheyWereInterrupted) {
    const std::string file = scratch("kept.json");
    Fake fake;
    fake.fails_at = "qa";
    const std::vector<SceneTask> tasks = tasks_of(fake.suites, {});
    Session session;
    session.results.commit = "c";
    EXPECT_THROW(run_scenes(session, tasks, keeping(file)), std::runtime_error);
    EXPECT_THAT(fake.ran, testing::ElementsAre("pa", "pb", "qa"));
    fake.ran.clear();
    fake.fails_at.clear();
    Session next;
    next.results.commit = "c";
    take_over(next.results, file);
    EXPECT_EQ(next.results.rows.size(), 4U);
    run_scenes(next, tasks, keeping(file));
    EXPECT_THAT(fake.ran, testing::ElementsAre("qa", "qb"));
    EXPECT_EQ(next.results.rows.size(), 8U);
    ASSERT_EQ(next.results.runs.size(), 4U);
    EXPECT_EQ(next.results.runs[3].rows, 2U);
    // All is there: nothing runs.
    fake.ran.clear();
    Session last;
    last.results.commit = "c";
    take_over(last.results, file);
    run_scenes(last, tasks, keeping(file));
    EXPECT_TRUE(fake.ran.empty());
    std::remove(file.c_str());
}

TEST(SceneRuns, RefuseRowsOfAnotherBuild) {
    const std::string file = scratch("other.json");
    Results kept;
    kept.commit = "old";
    write_text_file(file, to_json(kept, Pictures::kKeep));
    Results now;
    now.commit = "new";
    EXPECT_THROW(take_over(now, file), std::runtime_error);
    now.commit = "old";
    now.methods = {"default"};
    EXPECT_THROW(take_over(now, file), std::runtime_error);
    now.methods.clear();
    take_over(now, file);
    std::remove(file.c_str());
    take_over(now, file);  // no file yet: nothing to take over
}

TEST(SceneRuns, TakeThoseThatAreNamedAndEstimateTheRest) {
    Fake fake;
    EXPECT_EQ(tasks_of(fake.suites, {"b"}).size(), 2U);
    const std::vector<SceneTask> tasks = tasks_of(fake.suites, {});
    EXPECT_LT(seconds_left(tasks, 0, {}), 0.0);
    // One scene of p took 4 s: the other will, and those of q, of which nothing is known.
    EXPECT_EQ(seconds_left(tasks, 1, {{"p", "a", 4.0, 2, 0.0}}), 12.0);
    EXPECT_EQ(seconds_left(tasks, 3, {{"p", "a", 4.0, 2, 0.0}, {"q", "a", 1.0, 2, 0.0}}), 1.0);
}

}  // namespace
}  // namespace zoned::bench
