-- The rules of @GAME@: tag. One player is "it"; coming near another passes it on.
local TAGGED = 100        -- our kind of event; kinds below 16 are the server's
local PLAIN, IT = 0, 1    -- appearances, which clients draw
local REACH_M, PAUSE_S = 1.5, 1

local function tag(entity)
  if state.it then set_appearance(state.it, PLAIN) end
  state.it = entity
  state.safe_until = now() + ticks(PAUSE_S)
  set_appearance(entity, IT)
  set_field(entity, "tags", field(entity, "tags") + 1)   -- declared in world.txtpb, known to clients
  announce(entity, TAGGED)     -- to all who hear of that player, exactly once
end

function on_leave(client, avatar)
  if state.it == avatar then state.it = nil end
  despawn(avatar)
end

function on_tick()
  if not state.it then
    local first = avatars()[1]
    if first then tag(first) end
  elseif now() >= state.safe_until then
    local x, y, z = position(state.it)
    for _, other in ipairs(near(x, y, z, REACH_M, "player")) do
      if other ~= state.it then
        tag(other)
        return
      end
    end
  end
end
