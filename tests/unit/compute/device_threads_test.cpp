// Where a CPU device's threads run: on all of the CPUs, not two of them on one.
#include "tests/unit/compute/device_fixture.h"

#include <sched.h>
#include <unistd.h>

#include <fstream>
#include <set>

namespace zoned::compute {
namespace {

/// CPUs to which some thread of this process is bound alone.
std::set<std::string> bound_to() {
    std::set<std::string> cpus;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
        std::ifstream status(task.path() / "status");
        const std::string name = "Cpus_allowed_list:\t";
        for (std::string line; std::getline(status, line);) {
            if (line.starts_with(name) && line.find_first_of("-,") == std::string::npos) {
                cpus.insert(line.substr(name.size()));
            }
        }
    }
    return cpus;
}

using DeviceThreads = DeviceTest;

TEST_F(DeviceThreads, OfPoclStayOnACpuEachWhereAllAreOurs) {
    cpu_set_t ours;
    CPU_ZERO(&ours);
    ASSERT_EQ(sched_getaffinity(0, sizeof(ours), &ours), 0);
    const long all = sysconf(_SC_NPROCESSORS_CONF);
    if (CPU_COUNT(&ours) != all || all < 2 || std::getenv("POCL_AFFINITY") != nullptr) {
        GTEST_SKIP() << "not all CPUs are ours, there is one, or the environment says otherwise";
    }
    ASSERT_TRUE(bound_to().empty());
    const auto device = open();
    ASSERT_NE(device, nullptr);
    if (device->info().platform.find("Portable Computing Language") == std::string::npos) {
        GTEST_SKIP() << "another driver than PoCL";
    }
    EXPECT_EQ(bound_to().size(), static_cast<std::size_t>(all));
}

}  // namespace
}  // namespace zoned::compute
