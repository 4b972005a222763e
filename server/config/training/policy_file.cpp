#include "server/config/training/policy_file.h"

#include "server/config/text/config_numbers.h"
#include "server/config/text/sha256.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <utility>

namespace zoned::config {

namespace {

namespace learning = ai::learning;
using google::protobuf::TextFormat;
using PolicyResult = core::Result<learning::Policy>;

static_assert(static_cast<int>(learning::Ego::kSpeedAcross) == proto::SPEED_ACROSS);
static_assert(static_cast<int>(learning::Ego::kHomeDistance) == proto::HOME_DISTANCE);
static_assert(static_cast<int>(learning::Facing::kHome) == proto::HOME);

/// Keeps the parser's first message.
class FirstMistake : public google::protobuf::io::ErrorCollector {
  public:
    void AddError(int line,
                  google::protobuf::io::ColumnNumber column,
                  const std::string& text) override {
        if (first.empty()) {
            first = std::to_string(line + 1) + ":" + std::to_string(column + 1) + ": " + text;
        }
    }

    std::string first;
};

std::string bytes_in_order(const proto::PolicyFile& file) {
    std::string bytes;
    google::protobuf::io::StringOutputStream stream(&bytes);
    {
        google::protobuf::io::CodedOutputStream out(&stream);
        out.SetSerializationDeterministic(true);
        file.SerializeToCodedStream(&out);
    }
    return bytes;
}

}  // namespace

proto::FlatNetwork message_of(const learning::NeuralNetwork& network) {
    proto::FlatNetwork message;
    message.set_inputs(static_cast<std::uint32_t>(network.inputs));
    for (const learning::NeuralNetwork::Neuron& node : network.nodes) {
        proto::FlatNetwork::Node& out = *message.add_node();
        if (node.activation == learning::Activation::kLinear) {
            out.set_linear(true);
        }
        out.set_bias(network.parameters[node.first]);
        for (std::uint32_t p = node.first + 1; p <= node.first + node.links; ++p) {
            out.add_from(network.source[p]);
            out.add_weight(network.parameters[p]);
        }
    }
    for (const std::uint16_t output : network.outputs) {
        message.add_output(output);
    }
    return message;
}

core::Result<learning::NeuralNetwork> network_of(const proto::FlatNetwork& message) {
    using Failed = core::Result<learning::NeuralNetwork>;
    learning::NeuralNetwork network;
    network.inputs = message.inputs();
    const auto narrow_value = [](std::uint32_t value) {
        // Beyond all values that a network may have: it is found below.
        return static_cast<std::uint16_t>(std::min<std::uint32_t>(value, 0xFFFF));
    };
    for (const proto::FlatNetwork::Node& node : message.node()) {
        if (node.from_size() != node.weight_size()) {
            return Failed::failure("node " + std::to_string(network.nodes.size()) + " has " +
                                   std::to_string(node.weight_size()) + " weights for " +
                                   std::to_string(node.from_size()) + " links");
        }
        network.nodes.push_back(
            {static_cast<std::uint32_t>(network.parameters.size()),
             static_cast<std::uint32_t>(node.from_size()),
             node.linear() ? learning::Activation::kLinear : learning::Activation::kSquash});
        network.parameters.push_back(node.bias());
        network.source.push_back(0);
        for (int k = 0; k < node.from_size(); ++k) {
            network.source.push_back(narrow_value(node.from(k)));
            network.parameters.push_back(node.weight(k));
        }
    }
    for (const std::uint32_t output : message.output()) {
        network.outputs.push_back(narrow_value(output));
    }
    std::string defect = defect_of(network);
    if (!defect.empty()) {
        return Failed::failure("its network cannot be used: " + defect);
    }
    return network;
}

std::string digest_of(const proto::PolicyFile& file) {
    proto::PolicyFile plain = file;
    plain.clear_digest();
    plain.DiscardUnknownFields();
    return sha256_hex(bytes_in_order(plain));
}

std::string policy_text(const learning::Policy& policy, const std::string& trained) {
    proto::PolicyFile file;
    file.set_version(kPolicyVersion);
    file.set_name(policy.name);
    file.set_trained(trained);
    file.set_facing(static_cast<proto::Facing>(policy.facing));
    for (const learning::PolicyInput& input : policy.inputs) {
        proto::Input& out = *file.add_input();
        if (input.variable.empty()) {
            out.set_ego(static_cast<proto::Ego>(input.ego));
        } else {
            out.set_variable(input.variable);
        }
        out.set_scale(static_cast<double>(input.scale));
        out.set_offset(static_cast<double>(input.offset));
    }
    *file.mutable_network() = message_of(policy.network);
    file.set_digest(digest_of(file));
    TextFormat::Printer printer;
    printer.SetUseShortRepeatedPrimitives(true);
    std::string text;
    printer.PrintToString(file, &text);
    return text;
}

std::vector<learning::PolicyInput> inputs_of(
    const google::protobuf::RepeatedPtrField<proto::Input>& inputs) {
    std::vector<learning::PolicyInput> out;
    for (const proto::Input& input : inputs) {
        out.push_back({static_cast<learning::Ego>(input.ego()),
                       input.variable(),
                       narrow(input.scale()),
                       narrow(input.offset())});
    }
    return out;
}

PolicyResult parse_policy(const std::string& text) {
    proto::PolicyFile file;
    TextFormat::Parser parser;
    FirstMistake errors;
    parser.RecordErrorsTo(&errors);
    parser.SetRecursionLimit(16);
    if (text.size() > kMaxPolicyBytes || !parser.ParseFromString(text, &file)) {
        return PolicyResult::failure("is no policy: " +
                                     (errors.first.empty() ? "too large" : errors.first));
    }
    if (file.version() != kPolicyVersion) {
        return PolicyResult::failure("has version " + std::to_string(file.version()) +
                                     ", this program reads " + std::to_string(kPolicyVersion));
    }
    if (file.digest() != digest_of(file)) {
        return PolicyResult::failure("was changed or damaged since it was trained: its digest is " +
                                     digest_of(file) + ", and it says " + file.digest());
    }
    auto network = network_of(file.network());
    if (!network) {
        return PolicyResult::failure("cannot be followed: " + network.error());
    }
    learning::Policy policy;
    policy.name = file.name();
    policy.facing = static_cast<learning::Facing>(file.facing());
    policy.inputs = inputs_of(file.input());
    policy.network = std::move(*network);
    const std::string defect = defect_of(policy);
    if (!defect.empty()) {
        return PolicyResult::failure("cannot be followed: " + defect);
    }
    return policy;
}

}  // namespace zoned::config
