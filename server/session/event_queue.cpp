#include "server/session/event_queue.h"

#include "proto/session.pb.h"

#include <google/protobuf/io/coded_stream.h>

#include <utility>

namespace zoned::session {

namespace {

using google::protobuf::io::CodedOutputStream;

/// Key of a field in protobuf's encoding: number and wire type (0 varint, 2 length-delimited).
constexpr std::uint8_t field_key(int field, int wire_type) {
    return static_cast<std::uint8_t>((field << 3) | wire_type);
}

}  // namespace

EventBody encode_event_body(const mailbox::EventOut& event) {
    proto::Event message;
    message.set_event_id(event.event.value);
    message.set_tick(event.tick);
    message.set_kind(event.kind);
    message.set_topic(event.topic);
    message.set_history(event.history);
    message.set_payload(event.payload.data(), event.payload.size());
    message.set_confirm(event.confirm);
    auto body = std::make_shared<std::vector<std::uint8_t>>(message.ByteSizeLong());
    message.SerializeWithCachedSizesToArray(body->data());
    return body;
}

std::vector<std::uint8_t> event_frame(std::uint64_t number, const EventBody& body) {
    // Serialised messages may be joined end to end: the parser merges them ("Last One Wins" in
    // protobuf's encoding guide). So the number, which differs per client, goes before the body,
    // which is the same for all.
    const std::size_t number_bytes = 1 + CodedOutputStream::VarintSize64(number);
    const std::size_t event_bytes = number_bytes + body->size();
    std::vector<std::uint8_t> frame(1 + CodedOutputStream::VarintSize64(event_bytes) + event_bytes);
    std::uint8_t* out = frame.data();
    *out++ = field_key(proto::ServerMessage::kEventFieldNumber, 2);
    out = CodedOutputStream::WriteVarint64ToArray(event_bytes, out);
    *out++ = field_key(proto::Event::kNumberFieldNumber, 0);
    out = CodedOutputStream::WriteVarint64ToArray(number, out);
    std::copy(body->begin(), body->end(), out);
    return frame;
}

EventQueue::EventQueue(std::uint64_t acknowledged, const std::vector<EventBody>& waiting)
    : newest_(acknowledged),
      acknowledged_(acknowledged) {
    for (const EventBody& body : waiting) {
        push(body);
    }
}

std::uint64_t EventQueue::push(EventBody body) {
    waiting_.push_back({++newest_, std::move(body)});
    return newest_;
}

bool EventQueue::acknowledge(std::uint64_t through) {
    if (through > newest_) {
        return false;
    }
    while (!waiting_.empty() && waiting_.front().number <= through) {
        waiting_.pop_front();
    }
    acknowledged_ = std::max(acknowledged_, through);
    return true;
}

}  // namespace zoned::session
