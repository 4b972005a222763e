#include "server/recording/record_items.h"

#include <limits>

namespace zoned::recording {

namespace {

using proto::RecordedItem;

std::string to_string(const mailbox::Bytes& bytes) {
    return {bytes.begin(), bytes.end()};
}

mailbox::Bytes to_bytes(const std::string& text) {
    return {text.begin(), text.end()};
}

template <class T, class Wide>
bool fits(Wide value, T& out) {
    if (value < static_cast<Wide>(std::numeric_limits<T>::min()) ||
        value > static_cast<Wide>(std::numeric_limits<T>::max())) {
        return false;
    }
    out = static_cast<T>(value);
    return true;
}

struct ToRecord {
    RecordedItem& out;

    void operator()(const mailbox::Join& m) const {
        RecordedItem::Join& r = *out.mutable_join();
        r.set_client(m.client.value);
        r.set_name(m.name);
        r.set_team(m.team);
        r.set_rights(m.rights);
        for (const double coordinate : m.spawn) {
            r.add_spawn(coordinate);
        }
        r.set_account(m.account);
        r.set_placed(m.placed);
    }

    void operator()(const mailbox::Leave& m) const {
        out.mutable_leave()->set_client(m.client.value);
        out.mutable_leave()->set_reason(static_cast<std::uint32_t>(m.reason));
    }

    void operator()(const mailbox::Input& m) const {
        out.mutable_input()->set_client(m.client.value);
        for (const motion::InputCommand& command : m.commands) {
            RecordedItem::InputTick& r = *out.mutable_input()->add_commands();
            r.set_tick(command.tick);
            r.set_move_x(command.move_x);
            r.set_move_z(command.move_z);
            r.set_yaw(command.yaw);
            r.set_pitch(command.pitch);
            r.set_buttons(command.buttons);
        }
    }

    void operator()(const mailbox::Acks& m) const {
        RecordedItem::Acks& r = *out.mutable_acks();
        r.set_client(m.client.value);
        r.set_newest(m.newest);
        r.set_bits(m.bits);
        r.set_rtt_us(m.rtt_us);
        r.set_rate_bytes_per_s(m.rate_bytes_per_s);
        r.set_rtt_variation_us(m.rtt_variation_us);
    }

    void operator()(const mailbox::Command& m) const {
        RecordedItem::Command& r = *out.mutable_command();
        r.set_client(m.client.value);
        r.set_kind(m.kind);
        r.set_payload(to_string(m.payload));
        r.set_number(m.number);
    }

    void operator()(const mailbox::Confirm& m) const {
        out.mutable_confirm()->set_client(m.client.value);
        out.mutable_confirm()->set_event(m.event.value);
    }

    void operator()(const mailbox::ViewReset& m) const {
        out.mutable_view_reset()->set_client(m.client.value);
    }

    void operator()(const mailbox::Reach& m) const {
        out.mutable_reach()->set_client(m.client.value);
        out.mutable_reach()->set_on(m.on);
    }

    void operator()(const mailbox::Freeze& m) const { out.mutable_freeze()->set_on(m.on); }

    void operator()(const mailbox::AuditRequest& m) const {
        out.mutable_audit_request()->set_client(m.client.value);
    }

    void operator()(const mailbox::SpawnOrder& m) const {
        RecordedItem::SpawnOrder& r = *out.mutable_spawn_order();
        r.set_number(m.number);
        r.set_type(m.type);
        r.set_yaw(m.yaw);
        for (const double coordinate : m.position) {
            r.add_position(coordinate);
        }
    }

    void operator()(const mailbox::MoveOrder& m) const {
        RecordedItem::MoveOrder& r = *out.mutable_move_order();
        r.set_number(m.number);
        r.set_entity(m.entity.value);
        for (const double coordinate : m.position) {
            r.add_position(coordinate);
        }
    }

    void operator()(const mailbox::NewBrains& m) const {
        out.mutable_new_brains()->set_config(*m.config);
    }

    void operator()(const mailbox::StoreAnswer& m) const {
        RecordedItem::StoreAnswer& r = *out.mutable_store_answer();
        r.set_number(m.number);
        r.set_act(static_cast<std::uint32_t>(m.act));
        r.set_status(static_cast<std::uint32_t>(m.status));
        r.set_zone(m.zone.value);
        r.set_target(m.target.value);
        r.set_scope(static_cast<std::uint32_t>(m.key.scope));
        r.set_account(m.key.account);
        r.set_character(m.key.character);
        r.set_key(m.key.key);
        r.set_value(to_string(m.value));
    }

    void operator()(const mailbox::Notice& m) const {
        out.mutable_notice()->set_client(m.client.value);
        out.mutable_notice()->set_text(m.text);
    }

    void operator()(const mailbox::SessionBegun& m) const {
        RecordedItem::SessionBegun& r = *out.mutable_session_begun();
        r.set_client(m.client.value);
        r.set_token_digest(to_string(m.token_digest));
        r.set_account(m.account);
        r.set_name(m.name);
        r.set_team(m.team);
        r.set_rights(m.rights);
        r.set_ticketed(m.ticketed);
    }

    void operator()(const mailbox::SessionProgress& m) const {
        RecordedItem::SessionProgress& r = *out.mutable_session_progress();
        r.set_client(m.client.value);
        r.set_commands(m.commands);
        r.set_events(m.events);
    }

    void operator()(const mailbox::StoreKept& m) const {
        out.mutable_store_kept()->set_tick(m.tick);
    }

    void operator()(const mailbox::CodecPrice& m) const {
        out.mutable_codec_price()->set_record_ns(m.record_ns);
        out.mutable_codec_price()->set_packet_ns(m.packet_ns);
    }
};

bool read_leave(const RecordedItem::Leave& r, mailbox::InboxItem& out) {
    if (r.reason() > static_cast<std::uint32_t>(mailbox::LeaveReason::kShutdown)) {
        return false;
    }
    out = mailbox::Leave{ClientId(r.client()), static_cast<mailbox::LeaveReason>(r.reason())};
    return true;
}

bool read_input(const RecordedItem::Input& r, mailbox::InboxItem& out) {
    mailbox::Input input;
    input.client = ClientId(r.client());
    if (static_cast<std::size_t>(r.commands_size()) > input.commands.kMost) {
        return false;
    }
    for (const RecordedItem::InputTick& from : r.commands()) {
        motion::InputCommand command;
        command.tick = from.tick();
        if (!fits(from.move_x(), command.move_x) || !fits(from.move_z(), command.move_z) ||
            !fits(from.yaw(), command.yaw) || !fits(from.pitch(), command.pitch) ||
            !fits(from.buttons(), command.buttons)) {
            return false;
        }
        input.commands.push_back(command);
    }
    out = std::move(input);
    return true;
}

bool read_spawn(const RecordedItem::SpawnOrder& r, mailbox::InboxItem& out) {
    mailbox::SpawnOrder order;
    order.number = r.number();
    if (r.position_size() != 3 || !fits(r.type(), order.type) || !fits(r.yaw(), order.yaw)) {
        return false;
    }
    for (int axis = 0; axis < 3; ++axis) {
        order.position[axis] = r.position(axis);
    }
    out = order;
    return true;
}

bool read_answer(const RecordedItem::StoreAnswer& r, mailbox::InboxItem& out) {
    mailbox::StoreAnswer answer;
    if (r.act() > static_cast<std::uint32_t>(mailbox::kLastStoreAct) ||
        r.status() > static_cast<std::uint32_t>(mailbox::StoreStatus::kRefused) ||
        r.scope() > static_cast<std::uint32_t>(mailbox::StoreScope::kCharacter) ||
        !fits(r.zone(), answer.zone.value)) {
        return false;
    }
    answer.number = r.number();
    answer.act = static_cast<mailbox::StoreAct>(r.act());
    answer.status = static_cast<mailbox::StoreStatus>(r.status());
    answer.target = EntityId(r.target());
    answer.key = {static_cast<mailbox::StoreScope>(r.scope()), r.account(), r.character(), r.key()};
    answer.value = to_bytes(r.value());
    out = std::move(answer);
    return true;
}

bool read_command(const RecordedItem::Command& r, mailbox::InboxItem& out) {
    mailbox::Command command{ClientId(r.client()), 0, to_bytes(r.payload()), r.number()};
    if (!fits(r.kind(), command.kind)) {
        return false;
    }
    out = std::move(command);
    return true;
}

mailbox::SessionBegun read_begun(const RecordedItem::SessionBegun& r) {
    return {ClientId(r.client()),
            to_bytes(r.token_digest()),
            r.account(),
            r.name(),
            r.team(),
            r.rights(),
            r.ticketed()};
}

}  // namespace

void to_record(const mailbox::InboxItem& item, RecordedItem& out) {
    std::visit(ToRecord{out}, item);
}

bool from_record(const RecordedItem& record, mailbox::InboxItem& out) {
    switch (record.item_case()) {
        case RecordedItem::kJoin: {
            const RecordedItem::Join& r = record.join();
            if (r.spawn_size() != 3) {
                return false;
            }
            out = mailbox::Join{ClientId(r.client()),
                                r.name(),
                                r.team(),
                                r.rights(),
                                {r.spawn(0), r.spawn(1), r.spawn(2)},
                                r.account(),
                                r.placed()};
            return true;
        }
        case RecordedItem::kLeave:
            return read_leave(record.leave(), out);
        case RecordedItem::kInput:
            return read_input(record.input(), out);
        case RecordedItem::kAcks: {
            const RecordedItem::Acks& r = record.acks();
            out = mailbox::Acks{ClientId(r.client()),
                                r.newest(),
                                r.bits(),
                                r.rtt_us(),
                                r.rate_bytes_per_s(),
                                r.rtt_variation_us()};
            return true;
        }
        case RecordedItem::kCommand:
            return read_command(record.command(), out);
        case RecordedItem::kConfirm:
            out = mailbox::Confirm{ClientId(record.confirm().client()),
                                   EventId(record.confirm().event())};
            return true;
        case RecordedItem::kViewReset:
            out = mailbox::ViewReset{ClientId(record.view_reset().client())};
            return true;
        case RecordedItem::kReach:
            out = mailbox::Reach{ClientId(record.reach().client()), record.reach().on()};
            return true;
        case RecordedItem::kFreeze:
            out = mailbox::Freeze{record.freeze().on()};
            return true;
        case RecordedItem::kAuditRequest:
            out = mailbox::AuditRequest{ClientId(record.audit_request().client())};
            return true;
        case RecordedItem::kCodecPrice:
            out = mailbox::CodecPrice{record.codec_price().record_ns(),
                                      record.codec_price().packet_ns()};
            return true;
        case RecordedItem::kNewBrains:
            out = mailbox::NewBrains{
                std::make_shared<const std::string>(record.new_brains().config()), nullptr};
            return true;
        case RecordedItem::kStoreAnswer:
            return read_answer(record.store_answer(), out);
        case RecordedItem::kSpawnOrder:
            return read_spawn(record.spawn_order(), out);
        case RecordedItem::kMoveOrder: {
            const RecordedItem::MoveOrder& r = record.move_order();
            if (r.position_size() != 3) {
                return false;
            }
            out = mailbox::MoveOrder{
                r.number(), EntityId(r.entity()), {r.position(0), r.position(1), r.position(2)}};
            return true;
        }
        case RecordedItem::kNotice:
            out = mailbox::Notice{ClientId(record.notice().client()), record.notice().text()};
            return true;
        case RecordedItem::kSessionBegun:
            out = read_begun(record.session_begun());
            return true;
        case RecordedItem::kSessionProgress: {
            const RecordedItem::SessionProgress& r = record.session_progress();
            out = mailbox::SessionProgress{ClientId(r.client()), r.commands(), r.events()};
            return true;
        }
        case RecordedItem::kStoreKept:
            out = mailbox::StoreKept{record.store_kept().tick()};
            return true;
        case RecordedItem::ITEM_NOT_SET:
            break;
    }
    return false;
}

}  // namespace zoned::recording
