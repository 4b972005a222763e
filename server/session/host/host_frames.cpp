#include "server/session/host/host_impl.h"

namespace zoned::session {

namespace {

bool parse(std::span<const std::uint8_t> frame, proto::ClientMessage& out) {
    return out.ParseFromArray(frame.data(), static_cast<int>(frame.size()));
}

}  // namespace

void SessionHost::Impl::on_frame(StreamId stream,
                                 std::span<const std::uint8_t> frame,
                                 double now_s) {
    ++stats.frames_in;
    stats.frame_bytes_in += frame.size();
    const auto it = streams.find(stream);
    if (it == streams.end()) {
        reject(Reject::kFrameNoStream);  // closed by us; frames in flight still arrive
        return;
    }
    Session* session = table.by_stream(stream);
    if (session == nullptr) {
        if (it->second.storing) {
            refuse(stream,
                   {proto::REFUSED_MALFORMED,
                    Reject::kHelloAgain,
                    "nothing may follow Hello before the server answers it"});
        } else if (frame.size() <= settings.max_frame_bytes && parse(frame, message_in) &&
                   message_in.has_hello()) {
            on_hello(stream, message_in.hello(), now_s);
        } else {
            refuse(stream,
                   {proto::REFUSED_MALFORMED,
                    Reject::kHelloMissing,
                    "the first message of a connection must be Hello"});
        }
        return;
    }
    if (frame.size() > settings.max_frame_bytes) {
        reject(Reject::kFrameOversize);
        suspend(*session,
                proto::CLOSING_PROTOCOL,
                "a frame of " + std::to_string(frame.size()) + " bytes came; at most " +
                    std::to_string(settings.max_frame_bytes) + " are taken",
                now_s);
        return;
    }
    if (!session->frames.take(now_s)) {
        reject(Reject::kFrameFlood);
        suspend(*session,
                proto::CLOSING_PROTOCOL,
                "more than " + std::to_string(settings.max_frames_per_s) + " messages a second",
                now_s);
        return;
    }
    if (!parse(frame, message_in)) {
        reject(Reject::kFrameMalformed);
        suspend(*session, proto::CLOSING_PROTOCOL, "a message could not be read", now_s);
        return;
    }
    session->last_heard_s = now_s;
    on_message(*session, message_in, now_s);
}

void SessionHost::Impl::on_message(Session& session,
                                   const proto::ClientMessage& message,
                                   double now_s) {
    using Case = proto::ClientMessage::MessageCase;
    switch (message.message_case()) {
        case Case::kHello:
            reject(Reject::kHelloAgain);
            suspend(session, proto::CLOSING_PROTOCOL, "Hello came twice on a connection", now_s);
            break;
        case Case::kCommand:
            on_command(session, message.command(), now_s);
            break;
        case Case::kEventAck:
            if (session.events.acknowledge(message.event_ack().through())) {
                session.progress_due = true;
            } else {
                reject(Reject::kEventAckAhead);
            }
            break;
        case Case::kConfirm:
            on_confirm(session, message.confirm().event_id());
            break;
        case Case::kViewReset:
            on_view_reset(session, now_s);
            break;
        case Case::kFreeze:
            on_freeze(session, message.freeze().on());
            break;
        case Case::kAudit:
            on_audit_request(session, now_s);
            break;
        case Case::kQuit:
            on_quit(session);
            break;
        case Case::kDatagram: {
            const std::string& sealed = message.datagram().sealed();
            on_datagram(nullptr,
                        &session,
                        {reinterpret_cast<const std::uint8_t*>(sealed.data()), sealed.size()},
                        now_s,
                        now_s);
            break;
        }
        case Case::MESSAGE_NOT_SET:
            reject(Reject::kFrameEmpty);
            break;
    }
}

void SessionHost::Impl::on_command(Session& session, const proto::Command& command, double now_s) {
    if (command.number() <= session.last_command) {
        // After a reconnect the client repeats its unacknowledged commands: acknowledge them again.
        reject(Reject::kCommandDuplicate);
        session.command_ack_due = true;
        return;
    }
    if (command.number() != session.last_command + 1) {
        reject(Reject::kCommandGap);
        suspend(session,
                proto::CLOSING_PROTOCOL,
                "command " + std::to_string(command.number()) + " came after command " +
                    std::to_string(session.last_command),
                now_s);
        return;
    }
    // From here the number is used up, whatever becomes of the command.
    session.last_command = command.number();
    session.command_ack_due = true;
    session.progress_due = true;
    if (!session.commands.take(now_s)) {
        reject(Reject::kCommandFlood);
    } else if (command.kind() > 0xFFFF) {
        reject(Reject::kCommandKind);
    } else if (command.payload().size() > settings.max_command_bytes) {
        reject(Reject::kCommandSize);
    } else {
        mailbox::Command out;
        out.client = session.client;
        out.kind = static_cast<std::uint16_t>(command.kind());
        out.payload.assign(command.payload().begin(), command.payload().end());
        out.number = command.number();
        output.to_zones(std::move(out));
    }
}

void SessionHost::Impl::on_confirm(Session& session, std::uint64_t event) {
    // Clients may repeat confirmations after a reconnect: each event is confirmed once.
    if (session.unconfirmed.erase(event) == 0) {
        reject(Reject::kConfirmUnknown);
        return;
    }
    output.to_zones(mailbox::Confirm{session.client, EventId{event}});
}

void SessionHost::Impl::on_view_reset(Session& session, double now_s) {
    if (!session.view_resets.take(now_s)) {
        reject(Reject::kViewResetFlood);  // each costs a whole view; the client will ask again
        return;
    }
    output.to_zones(mailbox::ViewReset{session.client});
}

void SessionHost::Impl::on_freeze(Session& session, bool on) {
    if (!session.may(mailbox::kRightFreeze)) {
        reject(Reject::kFreezeNoRight);
        return;
    }
    output.to_zones(mailbox::Freeze{on});
}

void SessionHost::Impl::on_audit_request(Session& session, double now_s) {
    if (!session.may(mailbox::kRightAudit)) {
        reject(Reject::kAuditNoRight);
    } else if (!session.audits.take(now_s)) {
        reject(Reject::kAuditFlood);
    } else {
        output.to_zones(mailbox::AuditRequest{session.client});
    }
}

void SessionHost::Impl::on_quit(Session& session) {
    // The client asked for it, so it needs no reason.
    const StreamId stream = session.stream;
    table.attach(session, StreamId{});
    streams.erase(stream);
    output.close_stream(stream);
    end(session, proto::CLOSING_UNSPECIFIED, "", mailbox::LeaveReason::kQuit);
}

}  // namespace zoned::session
