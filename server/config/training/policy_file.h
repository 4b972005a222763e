// policy_file: policies as text files: written by training, read for the agents of a world.
#pragma once

#include "server/ai/learning/policy.h"
#include "proto/training.pb.h"
#include "shared/core/result.h"

#include <string>

namespace zoned::config {

inline constexpr std::uint32_t kPolicyVersion = 1;
/// Larger files are no policies.
inline constexpr std::size_t kMaxPolicyBytes = 8U << 20;

proto::FlatNetwork message_of(const ai::learning::NeuralNetwork& network);

/// Fails with what is wrong with it.
core::Result<ai::learning::NeuralNetwork> network_of(const proto::FlatNetwork& message);

/// SHA-256 of all but the digest itself, hex.
std::string digest_of(const proto::PolicyFile& file);

/// Text with version and digest; `trained` says how, for people.
std::string policy_text(const ai::learning::Policy& policy, const std::string& trained);

/// The same, with inputs as they stand in a training file.
std::vector<ai::learning::PolicyInput> inputs_of(
    const google::protobuf::RepeatedPtrField<proto::Input>& inputs);

/// A policy that an agent can follow, from text that may come from anywhere: fails on what is no
/// text of this schema, another version, a digest that does not fit, or a network without meaning.
core::Result<ai::learning::Policy> parse_policy(const std::string& text);

}  // namespace zoned::config
