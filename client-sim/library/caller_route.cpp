#include "client-sim/library/caller_route.h"

#include <utility>

namespace zoned::library {

StreamWish CallerRoute::take_wish() {
    return std::exchange(wish_, StreamWish::kNothing);
}

void CallerRoute::opened() {
    if (!wanted_ || std::exchange(open_, true)) {
        return;
    }
    if (events_.opened) {
        events_.opened(true);
    }
}

void CallerRoute::receive(std::span<const std::uint8_t> frame) {
    if (open_ && events_.frame) {
        events_.frame({frame.begin(), frame.end()});
    }
}

void CallerRoute::closed(const std::string& reason) {
    if (!wanted_) {
        return;
    }
    wanted_ = false;
    open_ = false;
    out_.clear();
    if (events_.closed) {
        events_.closed(reason);
    }
}

void CallerRoute::set_events(link::TransportEvents events) {
    events_ = std::move(events);
}

void CallerRoute::open() {
    out_.clear();
    wanted_ = true;
    open_ = false;
    wish_ = StreamWish::kOpen;
}

void CallerRoute::send_frame(link::Bytes frame) {
    if (!open_) {
        return;
    }
    if (out_.size() >= kMostFrames) {
        wish_ = StreamWish::kClose;
        closed("the caller does not send what waits");
        return;
    }
    out_.push_back(std::move(frame));
}

void CallerRoute::close() {
    wanted_ = false;
    open_ = false;
    wish_ = StreamWish::kClose;
}

}  // namespace zoned::library
