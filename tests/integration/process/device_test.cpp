// Devices: a server opens OpenCL only when its world has work for it.
#include "tests/integration/process/fixture.h"

#include <csignal>
#include <cstdlib>

namespace zoned::testing_process {
namespace {

/// Whether a library whose name holds `word` is mapped into a running process.
bool maps(const Child& child, const std::string& word) {
    const std::string text = read("/proc/" + std::to_string(child.pid()) + "/maps");
    EXPECT_NE(text.find("zoned"), std::string::npos) << "the maps of another program";
    return text.find(word) != std::string::npos;
}

const std::vector<std::string> kHail = {"--set",
                                        "particles[0]={name: \"hail\" cosmetic: false most: "
                                        "2000000 emitter { y_m: 20 rate_hz: 1000 }}"};

TEST_F(Process, LoadsNoOpenClWhereNoParticlesAreSimulated) {
    const auto server = start_server();
    Child client("client-sim", play(1, 1));
    EXPECT_EQ(client.wait(kPatience), 0) << client.output();
    EXPECT_FALSE(maps(*server, "libOpenCL"));
    EXPECT_FALSE(maps(*server, "libpocl"));
    EXPECT_EQ(server->errors().find("particles:"), std::string::npos) << server->errors();
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
}

TEST_F(Process, LoadsNoOpenClForFewParticlesOrAgainstTheConfigsWill) {
    auto few = kHail;
    few.insert(few.end(), {"--set", "particles[hail].most=1000"});
    const auto small = start_server(few);
    EXPECT_FALSE(maps(*small, "libOpenCL"));
    EXPECT_NE(small->errors().find("too little for a device"), std::string::npos)
        << small->errors();
    auto none = kHail;
    none.insert(none.end(), {"--set", "compute.device=none"});
    const auto unwilling = start_server(none);
    EXPECT_FALSE(maps(*unwilling, "libOpenCL"));
    EXPECT_NE(unwilling->errors().find("as compute.device says"), std::string::npos)
        << unwilling->errors();
}

/// `zoned explain` with the dynamic loader's list of searched libraries on standard error.
struct Explained {
    explicit Explained(const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"explain", minimal()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        setenv("LD_DEBUG", "libs", 1);
        Child child("zoned", arguments);
        unsetenv("LD_DEBUG");
        code = child.wait(kPatience);
        output = child.output();
        loader = child.errors();
    }

    int code = -1;
    std::string output;
    std::string loader;
};

TEST_F(Process, ExplainsAWorldWithoutSimulatedParticlesWithoutLookingForOpenCl) {
    const Explained without({});
    EXPECT_EQ(without.code, 0);
    EXPECT_NE(without.output.find("none is simulated, no device is looked for"), std::string::npos)
        << without.output;
    EXPECT_NE(without.loader.find("find library=libc.so"), std::string::npos) << "no account";
    EXPECT_EQ(without.loader.find("OpenCL"), std::string::npos);
    const Explained with(kHail);
    EXPECT_EQ(with.code, 0);
    EXPECT_NE(with.output.find("particles: "), std::string::npos) << with.output;
    EXPECT_NE(with.loader.find("find library=libOpenCL"), std::string::npos);
}

TEST_F(Process, LooksForADeviceWhereThereIsWorkForOneAndSaysWhatItChose) {
    const auto server = start_server(kHail);
    const std::string log = server->errors();
    // Where no device is installed the log says why the CPU does it; the library may be missing.
    const bool chosen = log.find("particles: device ") != std::string::npos;
    const bool refused = log.find("particles: on the CPU, ") != std::string::npos;
    EXPECT_TRUE(chosen != refused) << log;
    EXPECT_EQ(log.find("too little"), std::string::npos) << log;
    if (chosen) {
        EXPECT_TRUE(maps(*server, "libOpenCL"));
        EXPECT_NE(log.find("CPU "), std::string::npos) << "the measured costs: " << log;
    }
    auto nobody = kHail;
    nobody.insert(nobody.end(), {"--set", "compute.device=\"no such device\""});
    const auto plain = start_server(nobody);
    EXPECT_NE(plain->errors().find("particles: on the CPU, "), std::string::npos)
        << plain->errors();
}

}  // namespace
}  // namespace zoned::testing_process
