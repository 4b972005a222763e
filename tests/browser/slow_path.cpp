#include "tests/browser/slow_path.h"

#include "shared/core/rng.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <thread>
#include <vector>

namespace zoned::testing_browser {

namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using Socket = asio::ip::tcp::socket;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

struct Ends {
    Socket near;
    Socket far;
};

/// One direction of a connection.
class Pipe : public std::enable_shared_from_this<Pipe> {
  public:
    Pipe(std::shared_ptr<Ends> ends,
         Socket& from,
         Socket& to,
         const SlowPath::PathSettings& settings,
         std::uint64_t seed)
        : ends_(std::move(ends)),
          from_(from),
          to_(to),
          settings_(settings),
          rng_(seed),
          timer_(from.get_executor()) {}

    void read() {
        from_.async_read_some(asio::buffer(room_),
                              [self = shared_from_this()](error_code error, std::size_t size) {
                                  if (error) {
                                      self->close();
                                      return;
                                  }
                                  self->take(size);
                                  self->read();
                              });
    }

  private:
    struct Chunk {
        Clock::time_point due;
        std::vector<char> bytes;
    };

    void take(std::size_t size) {
        const bool lost = static_cast<double>(rng_.unit()) < settings_.loss;
        const Seconds delay(settings_.one_way_s + (lost ? settings_.resend_s : 0.0));
        last_due_ =
            std::max(last_due_, Clock::now() + std::chrono::duration_cast<Clock::duration>(delay));
        waiting_.push_back({last_due_, {room_.begin(), room_.begin() + std::ptrdiff_t(size)}});
        if (waiting_.size() == 1) {
            pass_on();
        }
    }

    void pass_on() {
        timer_.expires_at(waiting_.front().due);
        timer_.async_wait([self = shared_from_this()](error_code /*error*/) {
            asio::async_write(self->to_,
                              asio::buffer(self->waiting_.front().bytes),
                              [self](error_code error, std::size_t /*size*/) {
                                  self->waiting_.pop_front();
                                  if (error) {
                                      self->close();
                                  } else if (!self->waiting_.empty()) {
                                      self->pass_on();
                                  }
                              });
        });
    }

    void close() {
        error_code ignored;
        ends_->near.close(ignored);
        ends_->far.close(ignored);
    }

    std::shared_ptr<Ends> ends_;
    Socket& from_;
    Socket& to_;
    SlowPath::PathSettings settings_;
    core::Rng rng_;
    asio::steady_timer timer_;
    Clock::time_point last_due_;
    std::array<char, 65536> room_{};
    std::deque<Chunk> waiting_;
};

}  // namespace

struct SlowPath::Proxy {
    Proxy(int port, PathSettings path)
        : settings(path),
          server(asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(port)) {
        accept();
        thread = std::thread([this] { io.run(); });
    }

    ~Proxy() {
        io.stop();
        thread.join();
    }

    void accept() {
        acceptor.async_accept([this](error_code error, Socket socket) {
            if (error) {
                return;
            }
            auto ends = std::make_shared<Ends>(Ends{std::move(socket), Socket(io)});
            ends->far.connect(server, error);
            for (Socket* end : {&ends->near, &ends->far}) {
                end->set_option(asio::ip::tcp::no_delay(true), error);
            }
            std::make_shared<Pipe>(ends, ends->near, ends->far, settings, 1)->read();
            std::make_shared<Pipe>(ends, ends->far, ends->near, settings, 2)->read();
            accept();
        });
    }

    PathSettings settings;
    asio::ip::tcp::endpoint server;
    asio::io_context io;
    asio::ip::tcp::acceptor acceptor{io,
                                     asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), 0)};
    std::thread thread;
};

SlowPath::SlowPath(int port, PathSettings settings)
    : proxy_(std::make_unique<Proxy>(port, settings)) {
}

SlowPath::~SlowPath() = default;

int SlowPath::port() const {
    return proxy_->acceptor.local_endpoint().port();
}

}  // namespace zoned::testing_browser
