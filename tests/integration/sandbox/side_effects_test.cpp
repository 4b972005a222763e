// The replay test of a game names what the rules ask of the system, by function and callback.
#include "server/zone/faults/decorated_rules.h"
#include "tests/harness/game_test.h"

#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <utility>

namespace zoned::harness {
namespace {

/// Rules that do something undeclared in one tick.
class Reaching final : public zone::DecoratedRules {
  public:
    Reaching(std::unique_ptr<zone::Rules> rules, std::function<void()> reach)
        : DecoratedRules(std::move(rules)),
          reach_(std::move(reach)) {}

    void on_tick(zone::RulesContext& context) override {
        if (context.now() == 30) {
            reach_();
        }
        DecoratedRules::on_tick(context);
    }

  private:
    std::function<void()> reach_;
};

class UndeclaredSideEffects : public GameTest {
  protected:
    UndeclaredSideEffects() {
        bots.bots = 2;
        bots.seconds = 2.0;
    }

    std::string found(const std::function<void()>& reach) {
        if (!SideEffects::work()) {
            return "";
        }
        wrap_rules = [reach](std::unique_ptr<zone::Rules> rules) {
            return std::make_unique<Reaching>(std::move(rules), reach);
        };
        return difference_between_runs();
    }

    static void expect_named(const std::string& found, const std::string& what) {
        if (SideEffects::work()) {
            EXPECT_EQ(found, "on_tick calls " + what);
        }
    }
};

TEST_F(UndeclaredSideEffects, AreNoneInTheSandbox) {
    EXPECT_EQ(found([] {}), "");
}

TEST_F(UndeclaredSideEffects, NameAClock) {
    expect_named(found([] { (void)std::chrono::steady_clock::now(); }), "clock_gettime, a clock");
    expect_named(found([] { (void)std::time(nullptr); }), "time, a clock");
}

TEST_F(UndeclaredSideEffects, NameAFile) {
    const std::string text = found([] { std::ifstream("score.txt").get(); });
    EXPECT_TRUE(!SideEffects::work() || text == "on_tick calls fopen64 ('score.txt'), a file" ||
                text == "on_tick calls fopen ('score.txt'), a file")
        << text;
}

TEST_F(UndeclaredSideEffects, NameARandomNumber) {
    expect_named(found([] { (void)std::random_device()(); }),
                 "std::random_device, a random number");
    expect_named(found([] { (void)std::rand(); }), "rand, a random number");
}

TEST_F(UndeclaredSideEffects, NameAThread) {
    expect_named(found([] { std::thread([] {}).join(); }), "pthread_create, a thread");
}

TEST_F(UndeclaredSideEffects, NameASocketAndTheEnvironment) {
    expect_named(found([] {
                     const int handle = ::socket(AF_INET, SOCK_DGRAM, 0);
                     ::close(handle);
                 }),
                 "socket, a socket");
    expect_named(found([] { (void)std::getenv("ZONED_NO_SUCH_THING"); }),
                 "getenv ('ZONED_NO_SUCH_THING'), the environment");
}

}  // namespace
}  // namespace zoned::harness
