// Fuzzing of the client's readers: frames, datagrams and sealed packets of a hostile server.
#include "client-sim/bot/bot.h"
#include "client-sim/measure/collector.h"
#include "tests/fuzz/fuzz.h"
#include "tests/unit/client/fake_server.h"
#include "shared/core/assert.h"
#include "shared/wire/record/record_codec.h"

namespace zoned::fuzz {

namespace {

constexpr int kMaxActions = 32;

enum What : std::uint8_t {
    kFrame,
    kDatagram,
    kSealed,  ///< the bytes are the body of a state packet
    kTime,    ///< as many thirtieths of a second as bytes
    kCut,
    kKinds
};

/// A bot that has joined a truthful server.
struct Session {
    Session() : collector(1, 28, 0.0) {
        server.sparks = true;
        server.entities[3].truth.position = Vec3(3.0F, 1.0F, 2.0F);
        server.entities[3].truth.velocity = Vec3(1.0F, 0.0F, 0.0F);
        bot::BotSettings settings;
        settings.script = bot::Script::kIdle;
        bots.push_back(std::make_unique<bot::Bot>(server, worlds, collector, settings));
        bots[0]->start(0.0);
        run(20);
    }

    void run(std::size_t ticks) {
        for (std::size_t i = 0; i < ticks; ++i) {
            now_s += 1.0 / 30.0;
            server.advance(now_s);
            bots[0]->advance(now_s);
            collector.advance(bots, now_s);
        }
    }

    test::FakeServer server;
    view::WorldCache worlds;
    measure::Collector collector;
    measure::Bots bots;
    double now_s = 0.0;
};

void act(Session& session, std::uint8_t what, std::span<const std::uint8_t> bytes) {
    link::Bytes copy(bytes.begin(), bytes.end());
    switch (what % kKinds) {
        case kFrame:
            session.server.send_raw_frame(std::move(copy));
            break;
        case kDatagram:
            session.server.send_raw_datagram(std::move(copy));
            break;
        case kSealed:
            session.server.send_raw_datagram(session.server.seal_packet(copy));
            break;
        case kTime:
            session.run(std::min<std::size_t>(bytes.size(), 60));
            break;
        default:
            session.server.cut();
    }
    session.run(1);
}

}  // namespace

/// Packets of coded records, none of which builds on another.
Bytes coded_states() {
    const wire::Quantization quantization;
    wire::record::RecordEncoder encoder(wire::record::RecordFormat(quantization, 1.0F / 30.0F));
    Bytes out;
    for (wire::entropy::PacketNumber number = 1; number <= 4; ++number) {
        wire::DownHead head;
        head.tick = 40 + static_cast<Tick>(number);
        head.zone = ZoneId(1);
        head.coded = true;
        std::vector<wire::record::CodedRecord> records;
        for (std::uint32_t e = 3; e < 8; ++e) {
            wire::record::CodedRecord& record = records.emplace_back();
            record.entity = EntityId(e);
            record.tick = head.tick;
            record.remove = e == 7 && number > 2;
            motion::KinematicState state;
            state.position = Vec3(static_cast<float>(e), 1.0F, static_cast<float>(number));
            state.velocity = Vec3(0.0F, 0.0F, 30.0F);
            record.state = wire::quantize(
                state, motion::PredictorOrder::kLinear, false, false, 0, quantization);
        }
        Bytes body;
        wire::write_down_head(head, body);
        encoder.sent(encoder.encode(number, head.tick, head.zone, records, body));
        Actions::add(kSealed, body, out);
    }
    Actions::add(kTime, Bytes(40), out);
    return out;
}

std::vector<Bytes> seeds() {
    std::vector<Bytes> all;
    Bytes events;
    proto::ServerMessage message;
    message.mutable_event()->set_number(1);
    message.mutable_event()->set_event_id(1 << 16);
    message.mutable_event()->set_confirm(true);
    message.mutable_event()->set_topic("world");
    Actions::add(kFrame, message.SerializeAsString(), events);
    proto::ParticleBurst burst;
    burst.set_seed(5);
    burst.set_count(12);
    for (int axis = 0; axis < 3; ++axis) {
        burst.add_position(1.0F);
        burst.add_velocity(2.0F);
    }
    message.mutable_event()->set_number(2);
    message.mutable_event()->set_event_id(2 << 16);
    message.mutable_event()->set_kind(proto::CORE_EVENT_PARTICLE_BURST);
    message.mutable_event()->set_payload(burst.SerializeAsString());
    Actions::add(kFrame, message.SerializeAsString(), events);
    message.mutable_command_ack()->set_through(1);
    Actions::add(kFrame, message.SerializeAsString(), events);
    message.mutable_joined()->set_avatar(3);
    message.mutable_joined()->set_zone(1);
    Actions::add(kFrame, message.SerializeAsString(), events);
    proto::AuditEntity& truth = *message.mutable_audit()->add_entities();
    message.mutable_audit()->set_tick(10);
    message.mutable_audit()->set_frozen(true);
    truth.set_entity(3);
    for (int i = 0; i < 3; ++i) {
        truth.add_position(1.0);
    }
    for (int i = 0; i < 4; ++i) {
        truth.add_orientation(0.5F);
    }
    Actions::add(kFrame, message.SerializeAsString(), events);
    Actions::add(kTime, Bytes(30), events);
    message.mutable_closing()->set_text("the server closes");
    Actions::add(kFrame, message.SerializeAsString(), events);
    all.push_back(events);
    Bytes states;
    wire::DownHead head;
    head.tick = 40;
    head.zone = ZoneId(1);
    Bytes body;
    wire::write_down_head(head, body);
    Actions::add(kSealed, body, states);
    wire::RecordHead record;
    record.entity = EntityId(3);
    wire::encode_remove(record.entity, body);
    Actions::add(kSealed, body, states);
    Actions::add(kDatagram, Bytes(40, 9), states);
    Actions::add(kCut, Bytes(), states);
    Actions::add(kTime, Bytes(10), states);
    all.push_back(states);
    all.push_back(coded_states());
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace zoned;
    fuzz::Session session;
    ZONED_ASSERT(session.bots[0]->client().state() == link::SessionState::kOnline,
                 "the truthful part of the run is good");
    fuzz::Actions actions({data, size});
    std::uint8_t what = 0;
    std::span<const std::uint8_t> bytes;
    for (int n = 0; n < fuzz::kMaxActions && actions.next(what, bytes); ++n) {
        fuzz::act(session, what, bytes);
    }
    session.run(3);
    std::vector<motion::CosmeticParticle> sparks;
    const view::View* const view = session.bots[0]->view();
    if (view != nullptr) {
        view->bursts().replay(view->tick(), sparks);
    }
    for (const motion::CosmeticParticle& spark : sparks) {
        ZONED_ASSERT(spark.position.allFinite() && spark.velocity.allFinite(),
                     "what passed as a burst can be drawn");
    }
    session.collector.end_run(session.bots, session.now_s);
    (void)session.collector.report(session.bots, 1);
    return 0;
}
