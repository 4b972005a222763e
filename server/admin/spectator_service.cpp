#include "server/admin/spectator_service.h"

#include <boost/asio/post.hpp>

#include <algorithm>
#include <chrono>
#include <utility>

namespace zoned::admin {

namespace {

/// Faces are told anew after so many updates, to viewers that missed them.
constexpr std::uint64_t kFacesEvery = 64;

}  // namespace

SpectatorService::SpectatorService(boost::asio::io_context& io,
                                   AdminRouter& router,
                                   SpectatorSource source,
                                   std::size_t& count)
    : io_(io),
      router_(router),
      source_(std::move(source)),
      count_(count),
      timer_(io) {
}

AdminResponse SpectatorService::admit(const AdminRequest& request) const {
    if (!request.upgrade) {
        AdminResponse response = problem(426, "this path speaks WebSocket alone");
        response.headers.emplace_back("Upgrade", "websocket");
        return response;
    }
    if (viewers_.size() >= kMostViewers) {
        return problem(503, "as many viewers as there may be look already");
    }
    AdminResponse response;
    response.status = 101;
    return response;
}

void SpectatorService::add(AdminStream stream,
                           const SpectatorConnection::UpgradeRequest& request,
                           std::uint64_t number) {
    const auto viewer = std::make_shared<SpectatorConnection>(
        std::move(stream), number, router_, [this](std::uint64_t gone) {
            viewers_.erase(gone);
            count_ = viewers_.size();
        });
    viewers_[number] = viewer;
    count_ = viewers_.size();
    viewer->accept(request, source_.scene());
    fresh_ = true;
    if (!sampling_) {
        sampling_ = true;
        sample();
    }
}

/// Goes on for as long as somebody looks.
void SpectatorService::sample() {
    if (viewers_.empty()) {
        sampling_ = false;
        hub_.clear();
        layers_ = {};
        return;
    }
    timer_.expires_after(std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double>(1.0 / source_.rate_hz)));
    timer_.async_wait([this](boost::system::error_code error) {
        if (!error) {
            sample();
        }
    });
    if (asked_) {
        return;
    }
    sample_->layers = 0;
    for (const auto& [number, viewer] : viewers_) {
        sample_->layers |= viewer->wish().layers;
    }
    asked_ = source_.sample(sample_, [this] {
        boost::asio::post(io_, [this] {
            asked_ = false;
            show();
        });
    });
}

void SpectatorService::show() {
    wishes_.clear();
    for (const auto& [number, viewer] : viewers_) {
        if (viewer->has_wish()) {
            wishes_.push_back(viewer->wish());
        }
    }
    if (wishes_.size() < viewers_.size()) {
        wishes_.clear();  // one looks closely from nobody knows where
    }
    const SpectatorMessage change = hub_.update(*sample_, wishes_);
    const auto everything = [this] {
        return hub_.everything();
    };
    const bool whole = std::exchange(fresh_, false) || ++shown_ % kFacesEvery == 0;
    const auto layers = layers_.update(*sample_, whole);
    // A viewer that is gone leaves the map while it is told.
    const auto all = viewers_;
    for (const auto& [number, viewer] : all) {
        viewer->send(change, everything);
        for (const SpectatorLayers::Message& layer : layers) {
            viewer->send_layer(layer.layer, layer.bytes);
        }
    }
}

void SpectatorService::close() {
    timer_.cancel();
    while (!viewers_.empty()) {
        const std::shared_ptr<SpectatorConnection> viewer = viewers_.begin()->second;
        viewer->abort();
    }
}

}  // namespace zoned::admin
