#include "tests/unit/client/fake_server.h"

#include "shared/motion/dead_reckoning.h"

#include <algorithm>
#include <cmath>

namespace zoned::test {

namespace {

wire::SealKey key_of(std::uint64_t turn, std::uint8_t direction) {
    wire::SealKey key;
    key.key.fill(static_cast<std::uint8_t>(turn * 2 + direction + 1));
    key.salt.fill(static_cast<std::uint8_t>(turn + 7));
    return key;
}

const motion::StaticGeometry& plane() {
    static const motion::StaticGeometry geometry({}, 0.0F);
    return geometry;
}

constexpr float kBound = 0.05F;

}  // namespace

FakeServer::FakeServer(const link::ConditionerSettings& path)
    : up_datagrams_(path, link::Conditioner::Mode::kDatagrams, 1),
      down_datagrams_(path, link::Conditioner::Mode::kDatagrams, 2),
      up_frames_(path, link::Conditioner::Mode::kFrames, 3),
      down_frames_(path, link::Conditioner::Mode::kFrames, 4) {
}

proto::WorldDescription FakeServer::world() const {
    proto::WorldDescription w;
    w.set_tick_rate_hz(30.0);
    const wire::Quantization q;
    proto::Quantization& out = *w.mutable_quantization();
    out.set_position_step_m(q.position_step_m);
    out.set_velocity_step_mps(q.velocity_step_mps);
    out.set_acceleration_step_mps2(q.acceleration_step_mps2);
    out.set_angular_velocity_step_rps(q.angular_velocity_step_rps);
    out.set_orientation_bits(static_cast<std::uint32_t>(q.orientation_bits));
    out.set_yaw_bits(static_cast<std::uint32_t>(q.yaw_bits));
    out.set_horizontal_extent_m(q.horizontal_extent_m);
    out.set_vertical_extent_m(q.vertical_extent_m);
    out.set_max_speed_mps(q.max_speed_mps);
    out.set_gravity_mps2(q.gravity_mps2);
    proto::EntityType& ball = *w.add_types();
    ball.set_name("ball");
    ball.set_max_acceleration_mps2(10.0F);
    ball.set_max_velocity_jump_mps(5.0F);
    proto::EntityType& player = *w.add_types();
    player.set_name("player");
    player.set_upright(true);
    player.set_character(true);
    player.set_max_acceleration_mps2(20.0F);
    player.set_max_velocity_jump_mps(10.0F);
    const motion::CharacterLimits limits;
    proto::CharacterLimits& l = *player.mutable_limits();
    l.set_radius(limits.radius);
    l.set_half_segment(limits.half_segment);
    l.set_speed(limits.speed);
    l.set_sprint_factor(limits.sprint_factor);
    l.set_acceleration(limits.acceleration);
    l.set_air_acceleration(limits.air_acceleration);
    l.set_jump_speed(limits.jump_speed);
    l.set_max_slope_cos(limits.max_slope_cos);
    l.set_step_down(limits.step_down);
    l.set_gravity(limits.gravity);
    if (sparks) {
        proto::CosmeticSystem& system = *w.add_cosmetics();
        for (int axis = 0; axis < 3; ++axis) {
            system.add_gravity(axis == 1 ? -9.81F : 0.0F);
            system.add_wind(0.0F);
        }
        proto::CosmeticSystem::Burst& burst = *system.mutable_burst();
        burst.set_cone_cosine(0.5F);
        burst.set_slowest(0.5F);
        burst.set_lifetime_min_s(1.0F);
        burst.set_lifetime_max_s(2.0F);
    }
    proto::Lod& lod = *w.add_lods();
    lod.set_position_bound_m(kBound);
    lod.set_orientation_bound_rad(0.1F);
    for (std::uint32_t id = 1; id <= 2; ++id) {
        proto::Zone& zone = *w.add_zones();
        zone.set_id(id);
        const double x = id == 1 ? 0.0 : 1000.0;
        for (const double v : {x, 0.0, 0.0}) {
            zone.add_origin(v);
        }
        zone.add_lower(x - 500.0);
        zone.add_lower(-500.0);
        zone.add_upper(x + 500.0);
        zone.add_upper(500.0);
    }
    return w;
}

void FakeServer::open() {
    ++opens;
    ++key_turn_;
    opening_ = true;
}

void FakeServer::close() {
    stream_ = false;
    opening_ = false;
    up_frames_.clear();
    down_frames_.clear();
}

void FakeServer::cut() {
    close();
    if (events_.closed) {
        events_.closed("cut");
    }
}

void FakeServer::send_frame(link::Bytes frame) {
    up_frames_.push(now_s_, std::move(frame));
}

void FakeServer::send_datagram(link::Bytes datagram) {
    if (!udp_blocked) {
        up_datagrams_.push(now_s_, std::move(datagram));
    }
}

void FakeServer::send_raw_datagram(link::Bytes datagram) {
    down_datagrams_.push(now_s_, std::move(datagram));
}

void FakeServer::send(const proto::ServerMessage& message) {
    if (!stream_) {
        return;
    }
    link::Bytes frame(message.ByteSizeLong());
    message.SerializeToArray(frame.data(), static_cast<int>(frame.size()));
    down_frames_.push(now_s_, std::move(frame));
}

void FakeServer::advance(double now_s) {
    if (stopped) {
        stopped_s_ += now_s - now_s_;
        now_s_ = now_s;
        return;
    }
    now_s_ = now_s;
    if (opening_) {
        opening_ = false;
        stream_ = true;
        if (websocket) {
            down_.emplace(wire::Seal::none());
            up_.emplace(wire::Seal::none());
            tunnel_ = true;
            events_.opened(true);
        } else {
            down_.emplace(key_of(key_turn_, 0));
            up_.emplace(key_of(key_turn_, 1));
            events_.opened(false);
        }
    }
    link::Bytes bytes;
    while (up_frames_.pop_due(now_s, bytes)) {
        on_frame(bytes);
    }
    while (up_datagrams_.pop_due(now_s, bytes)) {
        on_datagram(bytes, false);
    }
    const auto due = static_cast<Tick>(std::floor(clock_s() / kTickS + 1e-6));
    if (tick == 0) {
        tick = due;
        first_tick_ = due;
    }
    while (tick < due) {
        ++tick;
        step(now_s);
    }
    while (down_frames_.pop_due(now_s, bytes)) {
        events_.frame(std::move(bytes));
    }
    while (down_datagrams_.pop_due(now_s, bytes)) {
        events_.datagram(std::move(bytes));
    }
}

void FakeServer::step(double) {
    for (auto& [id, e] : entities) {
        if (!frozen) {
            e.truth.position += e.truth.velocity * static_cast<float>(kTickS);
        }
    }
    if (avatar) {
        const auto input = inputs_.find(tick);
        if (input != inputs_.end()) {
            last_input_ = input->second;
        }
        avatar = motion::apply_input(
            *avatar, last_input_, motion::CharacterLimits{}, plane(), static_cast<float>(kTickS));
    }
    if (!session_ || !down_ || stalled || !states) {
        return;
    }
    wire::DownHead head;
    head.tick = tick;
    head.zone = ZoneId(1);
    head.has_widened = widened != wire::Widened{};
    head.widened = widened;
    if (avatar) {
        head.has_own = true;
        head.own.avatar = EntityId(kAvatar);
        head.own.input_tick = tick;
        head.own.input_missing = inputs_.find(tick) == inputs_.end();
        const Tick newest = inputs_.empty() ? tick : inputs_.rbegin()->first;
        head.own.input_lead = static_cast<std::int8_t>(std::clamp<Tick>(newest - tick, -100, 100));
        head.own.state = *avatar;
    }
    std::vector<std::uint8_t> body;
    wire::write_down_head(head, body);
    publish(body);
    link::Bytes datagram = seal_packet(body);
    if (tunnel_) {
        proto::ServerMessage message;
        message.mutable_datagram()->set_sealed(datagram.data(), datagram.size());
        send(message);
    } else if (!udp_blocked) {
        send_raw_datagram(std::move(datagram));
    }
}

void FakeServer::publish(std::vector<std::uint8_t>& body) {
    const wire::Quantization q;
    for (auto& [id, e] : entities) {
        if (e.hidden_from_client) {
            if (e.sent) {
                wire::encode_remove(EntityId(id), body);
            }
            continue;
        }
        const auto elapsed =
            static_cast<float>(tick - e.published_tick) * static_cast<float>(kTickS);
        const motion::KinematicState now =
            motion::predict(e.published, motion::PredictorOrder::kLinear, elapsed);
        const bool breach =
            e.published_tick >= 0 && (now.position - e.truth.position).norm() > kBound;
        if (breach) {
            e.breach_tick = tick;
        }
        const bool due = e.published_tick < 0 || breach || frozen || tick - e.published_tick > 20;
        if (due) {
            e.published_tick = tick;
            e.published = wire::dequantize(
                wire::quantize(e.truth, motion::PredictorOrder::kLinear, false, false, 0, q),
                false,
                q);
        }
        // Absolute every tick: this fake need not care about loss.
        motion::KinematicState told = e.published;
        told.position += e.lie;
        wire::RecordHead head;
        head.entity = EntityId(id);
        head.keyframe = static_cast<std::uint8_t>(keyframe_++ % wire::kKeyframeNumbers);
        head.tick_low = static_cast<std::uint8_t>(e.published_tick);
        wire::encode_absolute(
            head,
            wire::quantize(told, motion::PredictorOrder::kLinear, false, false, 0, q),
            false,
            q,
            body);
        e.sent = true;
    }
}

link::Bytes FakeServer::seal_packet(const std::vector<std::uint8_t>& body) {
    const std::uint64_t sequence = next_sequence_++;
    wire::DownTransport transport;
    transport.send_time_us =
        static_cast<std::uint32_t>(static_cast<std::uint64_t>(clock_s() * 1e6));
    transport.ack_low = static_cast<std::uint16_t>(acks_.newest());
    transport.ack_bits = acks_.bits();
    transport.ack_delay_10us =
        static_cast<std::uint16_t>(std::clamp((now_s_ - newest_received_s_) * 1e5, 0.0, 65535.0));
    std::vector<std::uint8_t> plain(wire::kDownTransportBytes);
    wire::write_transport(transport, plain.data());
    plain.insert(plain.end(), body.begin(), body.end());
    link::Bytes datagram(wire::kDatagramHeaderBytes);
    wire::write_datagram_header({kConnection, static_cast<std::uint16_t>(sequence)},
                                datagram.data());
    const link::Bytes header = datagram;
    down_->seal(sequence, header, plain, datagram);
    return datagram;
}

void FakeServer::on_datagram(const link::Bytes& datagram, bool tunnel) {
    const auto header = wire::read_datagram_header(datagram);
    if (!header || !up_) {
        return;
    }
    const std::uint64_t sequence =
        wire::expand_sequence(header->sequence_low, replay_.newest() + 1);
    std::vector<std::uint8_t> plain;
    const std::span<const std::uint8_t> all(datagram);
    if (!replay_.fresh(sequence) || !up_->open(sequence,
                                               all.first(wire::kDatagramHeaderBytes),
                                               all.subspan(wire::kDatagramHeaderBytes),
                                               plain)) {
        return;
    }
    replay_.mark(sequence);
    acks_.on_received(sequence);
    newest_received_s_ = now_s_;
    ++input_packets;
    tunnelled_packets += tunnel ? 1 : 0;
    tunnel_ = tunnel;
    std::vector<motion::InputCommand> commands_in;
    if (wire::read_commands(std::span<const std::uint8_t>(plain).subspan(wire::kUpTransportBytes),
                            commands_in)) {
        for (const motion::InputCommand& c : commands_in) {
            if (c.tick > tick) {
                inputs_[c.tick] = c;
            }
        }
    }
}

void FakeServer::hello(const proto::Hello& hello) {
    proto::ServerMessage message;
    if (refuse_elsewhere) {
        message.mutable_refused()->set_reason(proto::REFUSED_ELSEWHERE);
        message.mutable_refused()->mutable_redirect()->set_tcp_port(4242);
        send(message);
        return;
    }
    if (refuse || (!hello.resume_token().empty() && !accept_resume)) {
        message.mutable_refused()->set_reason(refuse ? proto::REFUSED_TICKET
                                                     : proto::REFUSED_RESUME);
        send(message);
        return;
    }
    const bool resumed = !hello.resume_token().empty();
    proto::Welcome& welcome = *message.mutable_welcome();
    welcome.set_client_id(1);
    welcome.set_connection_id(kConnection);
    welcome.set_udp_port(1);
    welcome.set_resume_token("0123456789abcdef");
    welcome.set_grace_s(30);
    welcome.set_resumed(resumed);
    welcome.set_last_command(resumed ? last_command_ : 0);
    welcome.set_rights(rights);
    welcome.set_config_digest("fake");
    if (!websocket) {
        welcome.set_datagram_key_down(key_of(key_turn_, 0).bytes());
        welcome.set_datagram_key_up(keyless ? "" : key_of(key_turn_, 1).bytes());
    }
    if (!resumed) {
        *welcome.mutable_world() = world();
        next_sequence_ = 1;
        replay_ = {};
        acks_ = {};
        last_command_ = 0;
        sent_events_.clear();
    }
    session_ = true;
    send(message);
    if (!resumed) {
        avatar.emplace();
        avatar->position = Vec3(0.0F, 0.9F, 0.0F);
        avatar->grounded = true;
        proto::ServerMessage joined;
        joined.mutable_joined()->set_avatar(kAvatar);
        joined.mutable_joined()->set_zone(1);
        joined.mutable_joined()->set_tick(tick);
        send(joined);
        return;
    }
    for (const proto::Event& event : sent_events_) {
        if (event.number() > hello.last_event()) {
            proto::ServerMessage again;
            *again.mutable_event() = event;
            send(again);
        }
    }
}

void FakeServer::on_frame(const link::Bytes& frame) {
    proto::ClientMessage message;
    if (!message.ParseFromArray(frame.data(), static_cast<int>(frame.size()))) {
        return;
    }
    received.push_back(message);
    if (message.has_hello()) {
        hello(message.hello());
    } else if (message.has_command()) {
        const proto::Command& c = message.command();
        if (c.number() == last_command_ + 1) {
            last_command_ = c.number();
            commands[c.number()] = c.payload();
        }
        if (ack_commands) {
            proto::ServerMessage ack;
            ack.mutable_command_ack()->set_through(last_command_);
            send(ack);
        }
    } else if (message.has_event_ack()) {
        acked_events = message.event_ack().through();
    } else if (message.has_confirm()) {
        confirmed.insert(message.confirm().event_id());
    } else if (message.has_datagram()) {
        const std::string& sealed = message.datagram().sealed();
        on_datagram(link::Bytes(sealed.begin(), sealed.end()), true);
    } else if (message.has_audit() && audit_on_request) {
        send_audit();
    } else if (message.has_freeze()) {
        frozen = message.freeze().on();
    }
}

void FakeServer::send_event(std::uint64_t event_id, bool confirm, const std::string& topic) {
    proto::Event event;
    event.set_number(sent_events_.size() + 1);
    event.set_event_id(event_id);
    event.set_tick(tick);
    event.set_kind(18);
    event.set_topic(topic);
    event.set_confirm(confirm);
    sent_events_.push_back(event);
    proto::ServerMessage message;
    *message.mutable_event() = event;
    send(message);
}

void FakeServer::send_raw_event(std::uint64_t number, std::uint64_t event_id) {
    proto::ServerMessage message;
    message.mutable_event()->set_number(number);
    message.mutable_event()->set_event_id(event_id);
    message.mutable_event()->set_tick(tick);
    send(message);
}

void FakeServer::send_audit() {
    proto::ServerMessage message;
    proto::AuditRecord& record = *message.mutable_audit();
    record.set_tick(tick);
    record.set_zone(1);
    record.set_frozen(frozen);
    record.set_avatar_discontinuity_tick(first_tick_);
    for (int i = 0; i < 3; ++i) {
        record.add_avatar_position(avatar ? static_cast<double>(avatar->position[i]) : 0.0);
    }
    for (const auto& [id, e] : entities) {
        if (e.leaked) {
            continue;
        }
        proto::AuditEntity& out = *record.add_entities();
        out.set_entity(id);
        out.set_type(0);
        for (int i = 0; i < 3; ++i) {
            out.add_position(static_cast<double>(e.truth.position[i]));
        }
        for (const float v : {1.0F, 0.0F, 0.0F, 0.0F}) {
            out.add_orientation(v);
        }
        out.set_distance_m(e.truth.position.norm());
        out.set_bound_m(kBound);
        out.set_bound_rad(0.1F);
        out.set_must_know(true);
        out.set_discontinuity_tick(e.discontinuity_tick);
        out.set_breach_tick(e.breach_tick);
        out.set_radii_tick(e.radii_tick);
        if (e.postponed) {
            proto::AuditUpdate& update = *record.add_updates();
            update.set_entity(id);
            update.set_postponed_tick(tick);
        }
        if (frozen) {
            const wire::QuantizedState s = wire::quantize(
                e.truth, motion::PredictorOrder::kLinear, false, false, 0, wire::Quantization{});
            for (const std::int32_t v : {s.position[0],
                                         s.position[1],
                                         s.position[2],
                                         s.orientation_largest,
                                         s.orientation[0],
                                         s.orientation[1],
                                         s.orientation[2],
                                         static_cast<std::int32_t>(s.appearance)}) {
                out.add_quantized(v);
            }
        }
    }
    send(message);
}

}  // namespace zoned::test
