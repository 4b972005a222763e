#include "server/cluster/nats_board.h"

#include "server/cluster/cluster_url.h"

#include <nats/nats.h>

#include <cmath>
#include <mutex>

namespace zoned::cluster {

namespace {

constexpr int kReconnectWaitMs = 250;
constexpr int kPingEveryMs = 5000;
/// A connection that leaves so many pings unanswered is gone.
constexpr int kPingsOut = 2;

struct Free {
    void operator()(natsOptions* p) const { natsOptions_Destroy(p); }

    void operator()(natsConnection* p) const { natsConnection_Destroy(p); }

    void operator()(jsCtx* p) const { jsCtx_Destroy(p); }

    void operator()(kvStore* p) const { kvStore_Destroy(p); }

    void operator()(kvEntry* p) const { kvEntry_Destroy(p); }

    void operator()(kvWatcher* p) const { kvWatcher_Destroy(p); }

    void operator()(jsPubAck* p) const { jsPubAck_Destroy(p); }

    void operator()(natsSubscription* p) const { natsSubscription_Destroy(p); }
};

template <class T>
using Owned = std::unique_ptr<T, Free>;

/// The library's words for the last error of this thread, else for the status.
std::string text_of(natsStatus status) {
    natsStatus last = NATS_OK;
    const char* text = nats_GetLastError(&last);
    return text != nullptr && *text != '\0' ? text : natsStatus_GetText(status);
}

std::string value_of(kvEntry* entry) {
    const auto* bytes = static_cast<const char*>(kvEntry_Value(entry));
    const int size = kvEntry_ValueLen(entry);
    return size > 0 ? std::string(bytes, static_cast<std::size_t>(size)) : std::string();
}

/// Without one the library prints to standard error. Each call says for itself what failed.
void ignore_errors(natsConnection* /*connection*/,
                   natsSubscription* /*subscription*/,
                   natsStatus /*status*/,
                   void* /*closure*/) {
}

class NatsSubscription final : public BoardSubscription {
  public:
    explicit NatsSubscription(std::function<void(const std::string&)> handler)
        : state_(std::make_shared<State>()) {
        state_->handler = std::move(handler);
    }

    ~NatsSubscription() override {
        if (subscription_) {
            static_cast<void>(natsSubscription_Unsubscribe(subscription_.get()));
        }
        // Once this is held, no message is being handled, and none will be.
        const std::lock_guard lock(state_->mutex);
        state_->handler = nullptr;
    }

    natsStatus begin(natsConnection* connection, const std::string& subject) {
        natsSubscription* made = nullptr;
        // The library calls back until it has noticed the end: the state lives until then.
        auto* kept = new std::shared_ptr<State>(state_);
        const natsStatus status =
            natsConnection_Subscribe(&made, connection, subject.c_str(), &on_message, kept);
        if (status != NATS_OK) {
            delete kept;
            return status;
        }
        subscription_.reset(made);
        return natsSubscription_SetOnCompleteCB(made, &on_complete, kept);
    }

  private:
    struct State {
        std::mutex mutex;
        std::function<void(const std::string&)> handler;
    };

    static void on_message(natsConnection* /*connection*/,
                           natsSubscription* /*subscription*/,
                           natsMsg* message,
                           void* closure) {
        const std::string bytes(natsMsg_GetData(message),
                                static_cast<std::size_t>(natsMsg_GetDataLength(message)));
        natsMsg_Destroy(message);
        const std::shared_ptr<State> state = *static_cast<std::shared_ptr<State>*>(closure);
        const std::lock_guard lock(state->mutex);
        if (state->handler) {
            state->handler(bytes);
        }
    }

    static void on_complete(void* closure) { delete static_cast<std::shared_ptr<State>*>(closure); }

    std::shared_ptr<State> state_;
    Owned<natsSubscription> subscription_;
};

class NatsBoard final : public Board {
  public:
    ~NatsBoard() override {
        kv_.reset();
        js_.reset();
        if (connection_) {
            natsConnection_Close(connection_.get());
        }
    }

    std::string open(const NatsSettings& settings) {
        realm_ = settings.realm;
        bucket_ = "zoned-" + settings.realm;
        patience_ms_ = std::llround(1e3 * settings.patience_s);
        Owned<natsOptions> options;
        natsStatus status = set_options(settings, options);
        if (status == NATS_OK) {
            natsConnection* made = nullptr;
            status = natsConnection_Connect(&made, options.get());
            connection_.reset(made);
        }
        if (status != NATS_OK) {
            std::string servers;
            for (const std::string& url : settings.urls) {
                servers += (servers.empty() ? "" : ", ") + without_secrets(url);
            }
            return "cannot connect to the cluster at " + servers + ": " +
                   natsStatus_GetText(status) +
                   "; is a NATS server running there, and are user, password or token right?";
        }
        jsOptions of_requests;
        jsOptions_Init(&of_requests);
        of_requests.Wait = patience_ms_;
        jsCtx* context = nullptr;
        status = natsConnection_JetStream(&context, connection_.get(), &of_requests);
        js_.reset(context);
        return status == NATS_OK ? open_bucket(settings.replicas) : "JetStream: " + text_of(status);
    }

    BoardResult<std::optional<BoardEntry>> get(const std::string& key) override {
        using Out = BoardResult<std::optional<BoardEntry>>;
        kvEntry* found = nullptr;
        const natsStatus status = kvStore_Get(&found, kv_.get(), key.c_str());
        const Owned<kvEntry> entry(found);
        if (status == NATS_NOT_FOUND) {
            return std::optional<BoardEntry>();
        }
        if (status != NATS_OK) {
            return Out::failure(
                {BoardFault::kUnreachable, "reading " + key + ": " + text_of(status)});
        }
        return std::optional(BoardEntry{value_of(found), kvEntry_Revision(found)});
    }

    BoardResult<std::uint64_t> put_if(const std::string& key,
                                      std::uint64_t expected,
                                      const std::string& value) override {
        using Out = BoardResult<std::uint64_t>;
        const std::string what = "writing " + key + ": ";
        if (!connected()) {
            return Out::failure({BoardFault::kUnreachable, what + "not connected"});
        }
        jsPubOptions options;
        jsPubOptions_Init(&options);
        options.MaxWait = patience_ms_;
        options.ExpectLastSubjectSeq = expected;
        options.ExpectNoMessage = expected == 0;
        jsPubAck* made = nullptr;
        jsErrCode code = static_cast<jsErrCode>(0);
        const std::string subject = "$KV." + bucket_ + "." + key;
        const natsStatus status = js_Publish(&made,
                                             js_.get(),
                                             subject.c_str(),
                                             value.data(),
                                             static_cast<int>(value.size()),
                                             &options,
                                             &code);
        const Owned<jsPubAck> ack(made);
        if (status == NATS_OK) {
            return static_cast<std::uint64_t>(ack->Sequence);
        }
        if (code == JSStreamWrongLastSequenceErr) {
            return Out::failure({BoardFault::kChanged, what + "it has another revision"});
        }
        // A server that answered with an error, or that has nobody for the subject, wrote nothing.
        const bool answered = code != static_cast<jsErrCode>(0) || status == NATS_NO_RESPONDERS ||
                              status == NATS_MAX_PAYLOAD || status == NATS_INVALID_ARG;
        return Out::failure(
            {answered ? BoardFault::kUnreachable : BoardFault::kUnknown, what + text_of(status)});
    }

    BoardResult<std::vector<std::pair<std::string, BoardEntry>>> list(
        const std::string& prefix) override {
        using Entries = std::vector<std::pair<std::string, BoardEntry>>;
        using Out = BoardResult<Entries>;
        kvWatchOptions options;
        kvWatchOptions_Init(&options);
        options.Timeout = patience_ms_;
        kvWatcher* made = nullptr;
        natsStatus status = kvStore_Watch(&made, kv_.get(), (prefix + ".>").c_str(), &options);
        const Owned<kvWatcher> watcher(made);
        Entries out;
        while (status == NATS_OK) {
            kvEntry* next = nullptr;
            status = kvWatcher_Next(&next, watcher.get(), patience_ms_);
            const Owned<kvEntry> entry(next);
            if (status == NATS_OK && next == nullptr) {
                return out;  // all that was there
            }
            if (status == NATS_OK) {
                out.emplace_back(kvEntry_Key(next),
                                 BoardEntry{value_of(next), kvEntry_Revision(next)});
            }
        }
        return Out::failure(
            {BoardFault::kUnreachable, "listing " + prefix + ": " + text_of(status)});
    }

    void publish(const std::string& subject, const std::string& bytes) override {
        const std::string full = subject_of(subject);
        if (connected()) {
            static_cast<void>(natsConnection_Publish(
                connection_.get(), full.c_str(), bytes.data(), static_cast<int>(bytes.size())));
        }
    }

    std::unique_ptr<BoardSubscription> subscribe(
        const std::string& subject,
        std::function<void(const std::string&)> handler) override {
        auto out = std::make_unique<NatsSubscription>(std::move(handler));
        if (out->begin(connection_.get(), subject_of(subject)) != NATS_OK) {
            return nullptr;
        }
        // The server has it when it answers: what is published from now on comes.
        static_cast<void>(natsConnection_FlushTimeout(connection_.get(), patience_ms_));
        return out;
    }

    [[nodiscard]] bool connected() const override {
        return natsConnection_Status(connection_.get()) == NATS_CONN_STATUS_CONNECTED;
    }

  private:
    static natsStatus set_options(const NatsSettings& settings, Owned<natsOptions>& out) {
        natsOptions* options = nullptr;
        natsStatus status = natsOptions_Create(&options);
        out.reset(options);
        std::vector<const char*> urls;
        bool secure = false;
        for (const std::string& url : settings.urls) {
            urls.push_back(url.c_str());
            secure = secure || url.rfind("tls://", 0) == 0;
        }
        const auto set = [&](natsStatus done) {
            status = status == NATS_OK ? done : status;
        };
        set(natsOptions_SetServers(options, urls.data(), static_cast<int>(urls.size())));
        set(natsOptions_SetName(options, settings.name.c_str()));
        set(natsOptions_SetTimeout(options, std::llround(1e3 * settings.connect_s)));
        set(natsOptions_SetSendAsap(options, true));
        set(natsOptions_SetMaxReconnect(options, -1));
        set(natsOptions_SetReconnectWait(options, kReconnectWaitMs));
        set(natsOptions_SetPingInterval(options, kPingEveryMs));
        set(natsOptions_SetMaxPingsOut(options, kPingsOut));
        set(natsOptions_SetErrorHandler(options, &ignore_errors, nullptr));
        // A request to a connection that is gone fails at once, and does not wait for the next.
        set(natsOptions_SetFailRequestsOnDisconnect(options, true));
        if (secure) {
            set(natsOptions_SetSecure(options, true));
        }
        return status;
    }

    std::string open_bucket(int replicas) {
        kvStore* store = nullptr;
        natsStatus status = js_KeyValue(&store, js_.get(), bucket_.c_str());
        if (status == NATS_NOT_FOUND) {
            kvConfig config;
            kvConfig_Init(&config);
            config.Bucket = bucket_.c_str();
            config.History = 1;
            config.StorageType = js_FileStorage;
            config.Replicas = replicas;
            status = js_CreateKeyValue(&store, js_.get(), &config);
            if (status != NATS_OK) {
                // Another server may have made it at the same moment.
                const std::string why = text_of(status);
                status = js_KeyValue(&store, js_.get(), bucket_.c_str());
                if (status != NATS_OK) {
                    return "cannot make the board " + bucket_ + ": " + why;
                }
            }
        }
        kv_.reset(store);
        return status == NATS_OK
                   ? std::string()
                   : "cannot open the board " + bucket_ + ": " + text_of(status) +
                         "; does the NATS server run with JetStream (nats-server -js)?";
    }

    [[nodiscard]] std::string subject_of(const std::string& subject) const {
        return "zoned." + realm_ + "." + subject;
    }

    std::string realm_;
    std::string bucket_;
    std::int64_t patience_ms_ = 2000;
    Owned<natsConnection> connection_;
    Owned<jsCtx> js_;
    Owned<kvStore> kv_;
};

}  // namespace

core::Result<std::unique_ptr<Board>> connect_nats_board(const NatsSettings& settings) {
    using Out = core::Result<std::unique_ptr<Board>>;
    auto board = std::make_unique<NatsBoard>();
    if (std::string wrong = board->open(settings); !wrong.empty()) {
        return Out::failure(std::move(wrong));
    }
    return Out(std::move(board));
}

}  // namespace zoned::cluster
