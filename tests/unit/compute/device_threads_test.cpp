// Where PoCL's threads run: one on each CPU where all are ours, else where the system puts them.
#include "tests/unit/compute/device_fixture.h"

#include <sched.h>
#include <unistd.h>

#include <fstream>
#include <set>

namespace zoned::compute {
namespace {

cpu_set_t ours() {
    cpu_set_t set;
    CPU_ZERO(&set);
    sched_getaffinity(0, sizeof(set), &set);
    return set;
}

/// The CPUs of all threads of this process whose CPU set differs from this thread's.
std::set<int> bound_to() {
    const cpu_set_t own = ours();
    std::set<int> cpus;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
        cpu_set_t set;
        CPU_ZERO(&set);
        const auto id = static_cast<pid_t>(std::stol(task.path().filename().string()));
        if (sched_getaffinity(id, sizeof(set), &set) != 0 || CPU_EQUAL(&set, &own)) {
            continue;
        }
        for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
            if (CPU_ISSET(cpu, &set)) {
                cpus.insert(cpu);
            }
        }
    }
    return cpus;
}

/// For a process that has not loaded OpenCL yet: prints how many CPUs threads are bound to
/// afterwards.
[[noreturn]] void open_and_count() {
    const auto device = Device::open({});
    if (!device.ok()) {
        std::fprintf(stderr, "%s\n", device.error().c_str());
    } else {
        std::fprintf(stderr, "bound to %zu CPUs\n", bound_to().size());
    }
    std::_Exit(device.ok() ? 0 : 1);
}

std::string bound(long cpus) {
    return "bound to " + std::to_string(cpus) + " CPUs";
}

class PoclThreads : public DeviceTest {
  protected:
    void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(PoclThreads, StayOnACpuEachWhereAllAreOurs) {
    const cpu_set_t set = ours();
    const long all = sysconf(_SC_NPROCESSORS_CONF);
    // On a machine with one CPU they are where this thread is.
    const bool apart = CPU_COUNT(&set) == all && all > 1;
    EXPECT_EXIT(
        {
            unsetenv("POCL_AFFINITY");
            open_and_count();
        },
        ::testing::ExitedWithCode(0),
        bound(apart ? all : 0));
}

/// Threads bound to a foreign CPU would not start.
TEST_F(PoclThreads, AreNotBoundWhereSomeCpusAreNotOurs) {
    EXPECT_EXIT(
        {
            unsetenv("POCL_AFFINITY");
            cpu_set_t one;
            CPU_ZERO(&one);
            CPU_SET(sched_getcpu(), &one);
            sched_setaffinity(0, sizeof(one), &one);
            const auto device = Device::open({});
            const bool left = std::getenv("POCL_AFFINITY") == nullptr;
            const bool alone = sysconf(_SC_NPROCESSORS_CONF) == 1;
            std::_Exit(device.ok() && bound_to().empty() && (left || alone) ? 0 : 1);
        },
        ::testing::ExitedWithCode(0),
        "");
}

TEST_F(PoclThreads, AreWhereTheEnvironmentWantsThem) {
    EXPECT_EXIT(
        {
            setenv("POCL_AFFINITY", "0", 1);
            open_and_count();
        },
        ::testing::ExitedWithCode(0),
        bound(0));
}

}  // namespace
}  // namespace zoned::compute
