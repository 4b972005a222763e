// ServerStore: when it has settled, all that was asked before has been told to be durable.
#include "server/app/storage/server_store.h"

#include "server/config/expand/load_settings.h"
#include "server/session/host/session_host.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <future>
#include <string>
#include <vector>

namespace zoned::app {
namespace {

namespace fs = std::filesystem;

TEST(ServerStores, AreSettledWhenAllThatWasAskedBeforeWasTold) {
    const std::string folder = testing::TempDir() + "zoned_server_store";
    fs::remove_all(folder);
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    ASSERT_TRUE(config::load_settings(ZONED_SOURCE_DIR "/config/minimal.txtpb",
                                      {"session.state_folder=\"" + folder + "\"",
                                       "store.file=\"" + folder + "/store.db\"",
                                       "store.durability=DURABLE_PROCESS"},
                                      settings,
                                      errors));
    session::SessionHost host({}, {});
    std::promise<void> begun;
    std::promise<void> go_on;
    std::atomic<std::uint64_t> told{0};
    ServerStore store(settings);
    store.start(host,
                {[&](const mailbox::StoreAnswer&) {
                     begun.set_value();
                     go_on.get_future().wait();
                 },
                 [&](std::uint64_t number) {
                     told = number;
                 }});
    const auto put = [&](std::uint64_t number) {
        mailbox::StoreRequest request;
        request.act = mailbox::StoreAct::kPut;
        request.number = number;
        request.key = {mailbox::StoreScope::kWorld, "", "", "key"};
        request.value = {1, 2, 3};
        return store.submit(1, {request}).number;
    };
    ASSERT_NE(put(1), 0U);
    begun.get_future().wait();
    // Requests from here on are one batch of the writer, which waits in the answer.
    const std::uint64_t asked = put(0);
    ASSERT_NE(asked, 0U);
    std::promise<std::uint64_t> settled;
    store.settle([&] { settled.set_value(told); });
    go_on.set_value();
    EXPECT_GE(settled.get_future().get(), asked);
    EXPECT_EQ(store.stop(), 0U);
    fs::remove_all(folder);
}

TEST(ServerStores, AreSettledAtOnceWhereNothingIsKept) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    ASSERT_TRUE(config::load_settings(
        ZONED_SOURCE_DIR "/config/minimal.txtpb", {"store.kind=STORE_NONE"}, settings, errors));
    bool settled = false;
    ServerStore(settings).settle([&] { settled = true; });
    EXPECT_TRUE(settled);
}

}  // namespace
}  // namespace zoned::app
