// Fuzzing of the server's readers: frames before and after the login, datagrams with and without a
// good seal. Only checked items reach the zones, and every answer can be read.
#include "tests/fuzz/fuzz.h"
#include "tests/unit/session/fake_client.h"
#include "shared/core/assert.h"

namespace zoned::fuzz {

namespace {

using namespace zoned::session;

constexpr int kMaxActions = 48;

enum What : std::uint8_t {
    kFrame,         ///< on the stream of a client that has logged in
    kFirstFrame,    ///< on a new stream
    kDatagram,      ///< as it is
    kSealed,        ///< the bytes are the content of the seal
    kTime,          ///< as many thirtieths of a second as bytes
    kOutbox,        ///< an event with these bytes, to be confirmed
    kStreamClosed,  ///< the client's stream breaks off; it comes back with its token
    kKinds
};

void check_inbox(const TestHost& host, const HostSettings& settings) {
    for (const mailbox::InboxItem& item : host.inbox) {
        if (const auto* input = std::get_if<mailbox::Input>(&item)) {
            ZONED_ASSERT(
                !input->commands.empty() && input->commands.size() <= wire::kMaxCommandsPerPacket,
                "an input holds one to eight commands");
            for (const motion::InputCommand& command : input->commands) {
                ZONED_ASSERT(command.tick <= host.tick + settings.input_window_ticks,
                             "no command is far ahead");
            }
        } else if (const auto* command = std::get_if<mailbox::Command>(&item)) {
            ZONED_ASSERT(command->payload.size() <= settings.max_command_bytes,
                         "payloads are limited");
        } else if (const auto* join = std::get_if<mailbox::Join>(&item)) {
            ZONED_ASSERT(!join->name.empty() && join->name.size() <= 32, "names are limited");
        }
    }
}

void act(TestHost& host,
         FakeClient& client,
         std::uint8_t what,
         std::span<const std::uint8_t> bytes) {
    switch (what % kKinds) {
        case kFrame:
            host.host.on_frame(client.stream, bytes, host.now_s);
            break;
        case kFirstFrame:
            host.host.on_frame(host.open(), bytes, host.now_s);
            break;
        case kDatagram:
            host.host.on_datagram(test_address(what), bytes, host.now_s);
            break;
        case kSealed:
            host.host.on_datagram(
                test_address(1),
                client.seal(++client.sequence, session::Bytes(bytes.begin(), bytes.end())),
                host.now_s);
            break;
        case kTime:
            host.advance(static_cast<double>(std::min<std::size_t>(bytes.size(), 300)) / 30.0);
            break;
        case kOutbox:
            host.emit({client.client}, std::string(bytes.begin(), bytes.end()), true);
            break;
        default:
            client.drop();
            client.resume(bytes.size());
    }
}

}  // namespace

std::vector<Bytes> seeds() {
    std::vector<Bytes> all;
    Bytes calm;
    proto::ClientMessage hello = hello_message("bob");
    hello.mutable_hello()->set_team("red");
    Actions::add(kFirstFrame, hello.SerializeAsString(), calm);
    Actions::add(kFrame, command_message(1, "chat").SerializeAsString(), calm);
    session::Bytes plain(wire::kUpTransportBytes);
    wire::write_transport(wire::UpTransport{3, 7, 100}, plain.data());
    wire::write_commands(commands_at(101, 4), plain);
    Actions::add(kSealed, plain, calm);
    Actions::add(kTime, Bytes(10), calm);
    Actions::add(kDatagram, Bytes(40, 3), calm);
    all.push_back(calm);
    Bytes events;
    Actions::add(kOutbox, std::string("hit"), events);
    proto::ClientMessage message;
    message.mutable_confirm()->set_event_id(1);
    Actions::add(kFrame, message.SerializeAsString(), events);
    message.mutable_event_ack()->set_through(1);
    Actions::add(kFrame, message.SerializeAsString(), events);
    Actions::add(kStreamClosed, Bytes(1), events);
    message.mutable_view_reset()->set_reason("diverged");
    Actions::add(kFrame, message.SerializeAsString(), events);
    message.mutable_audit();
    Actions::add(kFrame, message.SerializeAsString(), events);
    message.mutable_datagram()->set_sealed(std::string(30, 'x'));
    Actions::add(kFrame, message.SerializeAsString(), events);
    message.mutable_quit();
    Actions::add(kFrame, message.SerializeAsString(), events);
    all.push_back(events);
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    const session::HostSettings settings = session::dev_settings();
    session::TestHost host(settings);
    session::FakeClient client(host);
    ZONED_ASSERT(client.log_in(), "the first login is good");
    fuzz::Actions actions({data, size});
    std::uint8_t what = 0;
    std::span<const std::uint8_t> bytes;
    for (int n = 0; n < fuzz::kMaxActions && actions.next(what, bytes); ++n) {
        fuzz::act(host, client, what, bytes);
    }
    fuzz::check_inbox(host, settings);
    ZONED_ASSERT(host.ok, "every frame of the host can be read, and none follows the end");
    return 0;
}
