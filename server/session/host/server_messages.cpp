#include "server/session/host/server_messages.h"

#include "server/session/login/display_names.h"
#include "shared/core/utf8.h"

namespace zoned::session {

std::vector<std::uint8_t> serialise(const proto::ServerMessage& message) {
    std::vector<std::uint8_t> frame(message.ByteSizeLong());
    message.SerializeWithCachedSizesToArray(frame.data());
    return frame;
}

namespace {

/// Key and length of a field that is a message (Protocol Buffers, "Encoding").
void put_field_head(int field, std::size_t length, std::vector<std::uint8_t>& out) {
    for (std::uint64_t number : {std::uint64_t(field) << 3U | 2U, std::uint64_t(length)}) {
        for (; number >= 0x80U; number >>= 7U) {
            out.push_back(static_cast<std::uint8_t>(number | 0x80U));
        }
        out.push_back(static_cast<std::uint8_t>(number));
    }
}

void put_message(const google::protobuf::MessageLite& message, std::vector<std::uint8_t>& out) {
    const std::size_t at = out.size();
    out.resize(at + message.ByteSizeLong());
    message.SerializeWithCachedSizesToArray(out.data() + at);
}

}  // namespace

std::vector<std::uint8_t> world_field(const proto::WorldDescription& world) {
    std::vector<std::uint8_t> out;
    put_field_head(proto::Welcome::kWorldFieldNumber, world.ByteSizeLong(), out);
    put_message(world, out);
    return out;
}

std::vector<std::uint8_t> welcome_head(const proto::Welcome& welcome, std::size_t tail_bytes) {
    std::vector<std::uint8_t> out;
    put_field_head(
        proto::ServerMessage::kWelcomeFieldNumber, welcome.ByteSizeLong() + tail_bytes, out);
    put_message(welcome, out);
    return out;
}

std::vector<std::uint8_t> closing_frame(proto::ClosingReason reason,
                                        const std::string& text,
                                        const proto::Redirect* redirect) {
    proto::ServerMessage message;
    message.mutable_closing()->set_reason(reason);
    // Reasons may come from the rules of a game; a proto3 string must be UTF-8.
    message.mutable_closing()->set_text(core::is_clean_utf8(text) ? text : printable(text, 256));
    if (redirect != nullptr) {
        *message.mutable_closing()->mutable_redirect() = *redirect;
    }
    return serialise(message);
}

std::vector<std::uint8_t> joined_frame(const mailbox::Joined& joined) {
    proto::ServerMessage message;
    proto::Joined& out = *message.mutable_joined();
    out.set_avatar(joined.avatar.value);
    out.set_zone(joined.zone.value);
    out.set_tick(joined.tick);
    return serialise(message);
}

namespace {

void fill(const mailbox::AuditEntity& in, proto::AuditEntity& out) {
    out.set_entity(in.entity.value);
    out.set_type(in.type);
    for (const double p : in.position) {
        out.add_position(p);
    }
    for (const float q : in.orientation) {
        out.add_orientation(q);
    }
    out.set_distance_m(in.distance_m);
    out.set_bound_m(in.bound_m);
    out.set_bound_rad(in.bound_rad);
    out.set_must_know(in.must_know);
    out.set_discontinuity_tick(in.discontinuity_tick);
    out.set_radii_tick(in.radii_tick);
    out.set_breach_tick(in.breach_tick);
    for (const std::int32_t v : in.quantized) {
        out.add_quantized(v);
    }
    out.mutable_field_words()->Add(in.field_words.begin(), in.field_words.end());
    out.mutable_field_ticks()->Add(in.field_ticks.begin(), in.field_ticks.end());
}

void fill(const mailbox::AuditUpdate& in, proto::AuditUpdate& out) {
    out.set_entity(in.entity.value);
    out.set_postponed_tick(in.postponed_tick);
    out.set_leaving(in.leaving);
    for (const mailbox::AuditUpdate::Carried& packet : in.carried) {
        out.add_ticks(packet.tick);
        out.add_sequences(packet.sequence);
    }
}

}  // namespace

std::vector<std::uint8_t> audit_frame(const mailbox::AuditRecord& record) {
    proto::ServerMessage message;
    proto::AuditRecord& out = *message.mutable_audit();
    out.set_tick(record.tick);
    out.set_zone(record.zone.value);
    out.set_frozen(record.frozen);
    for (const double p : record.avatar_position) {
        out.add_avatar_position(p);
    }
    out.set_avatar_discontinuity_tick(record.avatar_discontinuity_tick);
    out.set_avatar_radii_tick(record.avatar_radii_tick);
    out.mutable_entities()->Reserve(static_cast<int>(record.entities.size()));
    for (const mailbox::AuditEntity& entity : record.entities) {
        fill(entity, *out.add_entities());
    }
    out.set_updates_since(record.updates_since);
    for (const mailbox::AuditUpdate& update : record.updates) {
        fill(update, *out.add_updates());
    }
    out.mutable_shared_clocks()->Add(record.shared_clocks.begin(), record.shared_clocks.end());
    out.mutable_shared_variables()->Add(record.shared_variables.begin(),
                                        record.shared_variables.end());
    out.mutable_doors()->Add(record.doors.begin(), record.doors.end());
    out.mutable_platforms()->Add(record.platforms.begin(), record.platforms.end());
    return serialise(message);
}

std::vector<std::uint8_t> command_ack_frame(std::uint64_t through) {
    proto::ServerMessage message;
    message.mutable_command_ack()->set_through(through);
    return serialise(message);
}

std::vector<std::uint8_t> ahead_frame(const proto::Redirect& redirect) {
    proto::ServerMessage message;
    *message.mutable_ahead() = redirect;
    return serialise(message);
}

std::vector<std::uint8_t> datagram_frame(std::span<const std::uint8_t> sealed) {
    proto::ServerMessage message;
    message.mutable_datagram()->set_sealed(sealed.data(), sealed.size());
    return serialise(message);
}

}  // namespace zoned::session
