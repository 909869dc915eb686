"""The path tracer's loop. One turn is one ray: a step of a walk, or a segment between surfaces.

The throughput `β` is that of the leading colour channel's density while the path is in a medium (see `channels`);
`weight` is what it is worth. Radiance is carried divided by the squared index of refraction, so that crossing a surface
scales nothing.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from nephrite.bssrdf import lobe
from nephrite.plugins import channels, emission, glints, guide, interface, jump, roulette, sequence, twin
from nephrite.plugins.camera import Result
from nephrite.plugins.exits import connection_count, found_by, leave, light_density, toward, unblocked
from nephrite.plugins.media import Media
from nephrite.plugins.settings import Settings
from nephrite.plugins.shortcut import hurry


@dr.syntax
def trace(s: Settings, scene: Any, media: Media, sampler: Any, source: Any) -> Result:
    """Trace the paths of `source`: one given ray per lane (`camera.OneRay`), or many from a film (`camera.Camera`)."""
    repeats = source.repeats
    longest = dr.norm(scene.bbox().extents()) if scene.bbox().valid() else 1.0
    context = mi.BSDFContext()
    connections = connection_count(scene)
    lamps = glints.lamps(scene)
    hurries = media.any_jump and not media.any_emission and s.multiple and s.max_steps > 1

    # fmt: off
    # --- The path ---------------------------------------------------------------------------------------------------
    ray = mi.Ray3f(source.first)                        # Next segment
    active = mi.Bool(source.active)                     # Lanes with work left
    fresh = mi.Bool(repeats)                            # Lanes that are to start a path
    paths = mi.UInt32(0)                                # Paths started
    position = mi.Point2f(0)                            # Where this path goes on the film
    L = mi.Spectrum(0)                                  # Radiance found by this path
    valid = mi.Bool(False)                              # Has it hit anything?
    depth = mi.UInt32(0)                                # Bounces
    order = mi.UInt32(0)                                # Events in media, on the whole path
    β = mi.Spectrum(1)                                  # Throughput of the leading channel's density
    initial = dr.sum(β)                                 # Throughput at the path's start, of all channels
    ratio = channels.solo(β)                            # Densities of the channels, relative to the leader's
    channel = mi.UInt32(0)                              # The leader
    last_p = mi.Point3f(0)                              # Last vertex that lights were connected to,
    last_pdf = mi.Float(0)                              # density of the direction chosen there,
    last_delta = mi.Bool(True)                          # and whether lights are found by that direction alone
    after_glint = mi.Bool(False)                        # Have lamps ahead been counted already?
    outside_yet = mi.Bool(True)                         # Has it made no step in any medium?

    # --- The walk ---------------------------------------------------------------------------------------------------
    within, within_shape = mi.UInt32(0), mi.UInt32(0)   # Material and shape that the path is in; 0: none
    outer, outer_shape = mi.UInt32(0), mi.UInt32(0)     # and those around it
    sigma_t, sigma_s = mi.Spectrum(0), mi.Spectrum(0)   # Coefficients per scene unit
    g, emitted = mi.Float(0), mi.Spectrum(0)            # Mean cosine, volumetric emission
    events, steps = mi.UInt32(0), mi.UInt32(0)          # Events and rays since entry
    planned = mi.Float(0)                               # Way to the next event, where it has been drawn already
    thin = mi.Bool(False)                               # Is the far side near, straight on from there?
    entered = mi.Float(0)                               # Light at entry
    entry_p = mi.Point3f(0)                             # Where the path has entered,
    entry_n = mi.Vector3f(0, 0, 1)                      # the outward normal there,
    entry_w = mi.Vector3f(0, 0, 1)                      # where it came from (for directional models),
    entry_side = mi.Float(1)                            # and whether the shape's normals point outward (1) or in (-1)
    deep = mi.Spectrum(0)                               # What scattering twice brings, where that is precomputed
    travelled, reach = mi.Float(0), mi.Float(0)         # Way since entry; length of the shape's bounding box
    cut, started = mi.Float(0), mi.Float(0)             # Light in walks that were cut short, and in all
    search = jump.idle() if media.any_jump else None    # The probe
    # fmt: on

    while dr.hint(active, label="translucent_path"):
        # --- Start the next path of a lane --------------------------------------------------------------------------
        if dr.hint(repeats, mode="scalar"):
            if fresh:
                ray, β, position = source.ray(sampler, paths, fresh)
                initial, ratio = dr.sum(β), channels.solo(β)
                L, valid, depth, order = mi.Spectrum(0), mi.Bool(False), mi.UInt32(0), mi.UInt32(0)
                last_delta, after_glint, outside_yet = mi.Bool(True), mi.Bool(False), mi.Bool(True)
                within, within_shape = mi.UInt32(0), mi.UInt32(0)
                outer, outer_shape, planned = mi.UInt32(0), mi.UInt32(0), mi.Float(0)
                paths += 1

        # --- Step: to the next event or the next surface, whichever is first ----------------------------------------
        searching = mi.Bool(False)
        if dr.hint(media.any_jump, mode="scalar"):
            searching = mi.Bool(search.active)
        inside = (within != 0) & ~searching
        leading = channels.pick(sigma_t, channel)
        begins = inside & outside_yet & (depth == 0)
        outside_yet &= ~inside
        free = -dr.log(1 - source.even(sequence.FREE_PATH, paths, sampler.next_1d(active), begins)) / leading
        if dr.hint(hurries, mode="scalar"):
            free = dr.select(planned > 0, planned, free)
            planned = dr.select(inside, 0, planned)
        # what would end at its next event goes through to the surface, for what of its light gets there
        through = inside & ~s.may_go_on(order + 1)
        if dr.hint(media.any_low, mode="scalar"):
            through |= inside & (events > 0) & media.low(within)
        ray.maxt = dr.select(inside & ~through & (leading > 0), free, dr.largest(mi.Float))
        if dr.hint(media.any_jump, mode="scalar"):
            ray.maxt = dr.select(searching, search.left, ray.maxt)
        end, straight = mi.Float(ray.maxt), active & inside & (steps == 0)
        if dr.hint(lamps, mode="scalar"):  # the first ray inside goes on to the far side: lamps behind
            ray.maxt = dr.select(straight, dr.largest(mi.Float), ray.maxt)
        hit = scene.ray_intersect_preliminary(ray, coherent=False, active=active)
        if dr.hint(lamps, mode="scalar"):
            thin = dr.select(straight, hit.t * leading < guide.THIN, thin)
            straight &= (outer == 0) & s.wants(order) & (depth + 1 < s.max_depth)
            light, straight = glints.straight_through(
                scene, media, lamps, hit, ray, within, within_shape, β / dr.sum(ratio), sigma_t, straight
            )
            L += light
            ray.maxt = end
        stops = hit.is_valid() & (hit.t <= end)
        # a walk that is farther from its entry than its shape is long has found a hole in it: let it go
        escapes = active & inside & ~stops & (dr.squared_norm(ray.o - entry_p) > dr.square(reach))
        scatters = active & inside & ~stops & ~escapes & (ray.maxt < dr.largest(mi.Float))
        distance = dr.minimum(dr.select(stops, hit.t, ray.maxt), 1e30)

        if dr.hint(media.any_emission, mode="scalar"):
            L[active & inside & s.wants(order)] += emission.along(
                dr.minimum(distance, 10 * longest), sampler.next_1d(active),
                β, ratio, sigma_t, emitted, media.lookup(media.eta, within), through,
            )  # fmt: skip

        along = dr.exp(-sigma_t * distance)
        u = [source.even(sequence.TURN + i, paths, sampler.next_1d(active), begins) for i in range(2)]
        early = inside & ~through & (events < guide.EVENTS) & (thin | media.low(within))
        out = guide.way_out(media, within, entry_n, early)
        turned, favour = guide.turn(lamps, ray(free), ray.d, g, u, sampler, early, out)
        if dr.hint(media.transport is not None, mode="scalar"):
            # precomputed objects: what would scatter a second time on this way, in expectation, less the twin's
            second = (1 - along) * sigma_s / dr.maximum(sigma_t, 1e-30)
            L[active & inside & (events == 1)] += β / dr.sum(ratio) * second * deep
            L[active & inside & (steps == 0)] -= deep * favour * twin.second(
                β, ratio, channel, sigma_t, sigma_s, media.lookup(media.eta, within), entry_n, ray.d, free, turned,
            )  # fmt: skip
        density = dr.select(through, 1, along * dr.select(scatters, sigma_t, 1))
        of_leader = dr.maximum(channels.pick(density, channel), 1e-30)
        stays = inside & ~escapes
        β[stays] = β * along * dr.select(scatters, sigma_s * favour, 1) / of_leader
        ratio[stays] = ratio * density / of_leader
        steps[active] += 1
        travelled[inside] += distance

        # --- Event: a new direction by the phase function -----------------------------------------------------------
        events[scatters] += 1
        order[scatters] += 1
        ray.o[scatters] = ray(distance)
        ray.d[scatters] = turned
        weight = β / dr.sum(ratio)
        dead = mi.Bool(False)

        # at the second event a diffusion model takes over, and looks for where the light comes out
        jumps = mi.Bool(False)
        if dr.hint(media.any_jump, mode="scalar"):
            jumps = scatters & (events == 2) & media.jumps(within)

        within = dr.select(escapes, outer, within)
        within_shape = dr.select(escapes, outer_shape, within_shape)
        outer, outer_shape = dr.select(escapes, 0, outer), dr.select(escapes, 0, outer_shape)
        stays = scatters | escapes | dead
        lit = mi.Bool(False)
        reaches = active & ~stays & ~searching
        if active & ~stays:
            si = hit.compute_surface_interaction(ray, mi.RayFlags.All, active & ~stays)
            si.n = media.winding.outward(si)
            identity = dr.reinterpret_array(mi.UInt32, si.shape)
            landed, landing_n, landing_weight = mi.Bool(False), mi.Vector3f(0, 0, 1), mi.Spectrum(0)
            at = si

            # A probe: count the point, go on along the chord, land at its end
            if dr.hint(media.any_jump, mode="scalar"):
                if searching:
                    counts = searching & si.is_valid() & (identity == within_shape)
                    search, ray.o = jump.follow(
                        search, scene, media, within, sigma_t, sigma_s, g, si, ray, entry_side, entry_p, entry_n, β,
                        sampler, counts, searching,
                    )  # fmt: skip
                    landed = searching & ~search.active & (search.total > 0)
                    dead |= searching & ~search.active & ~landed
                    landing_weight = search.share * search.total
                    landing_n = search.shading * dr.sign(dr.dot(search.shading, search.n))
                    at.p = dr.select(landed, search.p, at.p)
                    at.n = dr.select(landed, search.n, at.n)

            # Light that the path has run into
            emitter = si.emitter(scene, reaches)
            sees = reaches & (emitter != None) & s.wants(order)  # noqa: E711
            sees &= ~(after_glint & si.is_valid())
            if dr.hint(s.hide_emitters, mode="scalar"):
                sees &= depth > 0
            if sees:
                by_light = connections * light_density(scene, last_p, si, ~last_delta)
                L += weight * emitter.eval(si) * dr.select(last_delta, 1, found_by(last_pdf, by_light))

            goes_on = reaches & si.is_valid() & (depth + 1 < s.max_depth)
            valid |= reaches & si.is_valid()
            dead |= reaches & ~goes_on
            number = dr.select(goes_on, media.number(si.shape), 0)
            crossing, opaque = goes_on & (number != 0), goes_on & (number == 0)
            leaving = crossing & (identity == within_shape)
            stale = crossing & ~leaving & (outer != 0) & (identity == outer_shape)  # overlapping objects
            outside = dr.select(leaving, outer, within)  # material on the outer side of the surface
            eta = media.lookup(media.eta, number)
            eta = dr.select(leaving, dr.rcp(eta), eta)

            # The interface: reflect or refract
            x = interface.cross(si, ray.d, eta)
            outward = dr.select(leaving, -x.normal, x.normal)
            begins = outside_yet & (depth == 0)
            lot = source.even(sequence.INTERFACE, paths, sampler.next_1d(crossing), begins)
            reflects = crossing & (lot < x.reflectance)
            direction = dr.select(reflects, x.reflected, x.refracted)
            rough, rough_pdf, rough_delta = mi.Bool(False), mi.Float(0), mi.Bool(False)
            if dr.hint(media.any_rough, mode="scalar"):
                rough = crossing & ~stale & (media.lookup(media.rough, number) > 0)
                if rough:
                    si.sh_frame = mi.Frame3f(outward)
                    si.wi = si.to_local(-ray.d)
                    reflects, direction, bs_weight, rough_pdf, rough_delta = interface.scattered(
                        media, number, si, ray.d, sampler, rough
                    )
                    β *= bs_weight
                    dead |= rough_pdf <= 0

            # Lamps that are mirrored need no choice between the two
            glint = mi.Bool(False)
            if dr.hint(lamps, mode="scalar"):
                glint = crossing & ~leaving & ~rough & ~stale & s.wants(order)
                glint &= glints.may_meet(lamps, si.p, x.reflected)
                if glint:
                    L += weight * x.reflectance * glints.lamp(scene, si.spawn_ray(x.reflected), glint)
            passes = crossing & ~reflects & ~stale
            direction = dr.select(stale, ray.d, direction)
            outer = dr.select(stale, 0, outer)
            exits, enters = passes & leaving, passes & ~leaving

            # The local model: light that enters leaves at once, and where it entered
            if dr.hint(media.any_local, mode="scalar"):
                local = enters & media.local(number)
                if local:
                    landing_n = outward
                    landing_weight = mi.Spectrum(media.shown(number, *media.coefficients(number, si, local)))
                    order += 2
                landed |= local
                dead |= local & ~s.may_go_on(order)
                enters &= ~local

            # Where it leaves: the point, the direction, and the lobe that lights see
            from_number = dr.select(landed & searching, within, number)
            to_medium = dr.select(landed & searching, outer, outside)
            by_lobe = landed | (exits & ~rough & (events > 0) & (s.exit == "lobe"))
            eta_exit = media.lookup(media.eta, from_number)
            normalization = media.lookup(media.normalization, from_number)
            normal = dr.select(landed, landing_n, outward)
            if landed:
                direction, kept = leave(normal, eta_exit, normalization, sampler.next_2d(landed))
                β = weight * landing_weight * kept
                if dr.hint(media.directional is not None, mode="scalar"):
                    β *= media.directional.ratio(
                        within, sigma_t - sigma_s, sigma_s, entry_p, entry_n, entry_w, at.p, normal, direction
                    )
                ratio = channels.solo(β)
                weight = weight * landing_weight
            cos_out = dr.dot(direction, normal)
            lobe_pdf = lobe.pdf(cos_out, mi.fresnel(dr.maximum(cos_out, 0), eta_exit)[0], normalization)

            # Connect to lights
            connects = ((opaque & ~inside) | ((rough | by_lobe) & (to_medium == 0))) & ~dead & s.wants(order)
            bsdf = si.bsdf()
            if connects:
                lottery, drift = sampler.next_1d(connects), (at.p - entry_p) / dr.maximum(travelled, 1e-30)
                for i in range(connections):
                    ticket = dr.minimum((lottery + i) / connections, dr.one_minus_epsilon(mi.Float))
                    spot = mi.Point2f(ticket, sampler.next_1d(connects))
                    ds, light = scene.sample_emitter_direction(at, spot, False, connects)
                    local_d = si.to_local(ds.d)
                    value, pdf = mi.Spectrum(0), mi.Float(0)
                    if opaque:
                        value, pdf = bsdf.eval_pdf(context, si, local_d, opaque)
                    if dr.hint(media.any_rough, mode="scalar"):
                        if rough:
                            value, pdf = media.eval_surface(number, si, local_d, rough & (local_d.z > 0))
                    if by_lobe:
                        value, pdf = toward(
                            media, from_number, normal, direction, ds.d, mi.Float(events), g, drift, landed
                        )
                        if dr.hint(media.directional is not None, mode="scalar"):
                            value *= dr.select(landed, media.directional.ratio(
                                within, sigma_t - sigma_s, sigma_s, entry_p, entry_n, entry_w, at.p, normal, ds.d
                            ), 1)  # fmt: skip
                    mis = dr.select(ds.delta, 1, found_by(connections * ds.pdf, pdf)) / connections
                    L += unblocked(scene, at, ds, weight * value * light * mis, connects)

            # Choose the next direction on everything that light can't enter
            if opaque:
                bs, share = bsdf.sample(context, si, sampler.next_1d(opaque), sampler.next_2d(opaque), opaque)
                β *= share
                direction = si.to_world(bs.wo)
                last_pdf = bs.pdf
                last_delta = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta) | inside
                dead |= bs.pdf <= 0
            last_pdf = dr.select(by_lobe, lobe_pdf, dr.select(rough, rough_pdf, last_pdf))
            connected = (by_lobe | (rough & (reflects ^ leaving) & ~rough_delta)) & (to_medium == 0)
            last_delta = dr.select(opaque, last_delta, ~connected)
            last_p = dr.select(searching & ~landed, last_p, at.p)

            # Go over into another medium
            if passes & ~dead | landed:
                bounced = exits | landed
                depth[bounced] += 1
                β = dr.select(landed, β, β / dr.sum(ratio))
                ratio = channels.solo(β)
                back = landed & ~searching  # the local model never left the medium that it is in
                around_shape = dr.select(to_medium != 0, dr.select(back, within_shape, outer_shape), 0)
                outer = dr.select(back, outer, dr.select(bounced, 0, within))
                outer_shape = dr.select(back, outer_shape, dr.select(bounced, 0, within_shape))
                within = dr.select(bounced, to_medium, number)
                within_shape = dr.select(bounced, around_shape, identity)
                if within != 0:
                    absorbed, sigma_s = media.coefficients(within, si, enters | bounced)
                    sigma_t = absorbed + sigma_s
                    g = media.lookup(media.g, within)
                    if dr.hint(media.any_emission, mode="scalar"):
                        emitted = media.emitted(within, si, enters | bounced)
                    entered = dr.max(β)
                    started += entered
                    if dr.hint(media.transport is not None, mode="scalar"):
                        deep, kept = media.transported(within, si, outward, -ray.d, sampler.next_2d(), enters)
                        L += β * deep * twin.expected(sigma_t, sigma_s, kept)
                    chance = roulette.entering(entered, initial / len(β), depth)
                    dead |= sampler.next_1d() >= chance
                    β, entered = β / chance, entered / chance
                    lot = source.even(sequence.LEADER, paths, sampler.next_1d(), begins)
                    channel, β, ratio = channels.lead(β, sigma_t, lot)
                    events, steps, travelled = mi.UInt32(0), mi.UInt32(0), mi.Float(0)
                    entry_p, entry_n = si.p, outward
                    if dr.hint(media.directional is not None, mode="scalar"):
                        entry_w = -ray.d
                    reach = media.lookup(media.reach, within)
                    entry_side = dr.select(dr.dot(si.n, outward) > 0, mi.Float(1), mi.Float(-1))
            depth[opaque | (crossing & reflects & ~leaving)] += 1

            lit = (opaque | by_lobe) & ~last_delta & (within == 0)
            after_glint = (glint & reflects) | (straight & exits)
            following = at.spawn_ray(direction)
            following.time, following.wavelengths = ray.time, ray.wavelengths
            ray = dr.select(searching & ~landed, ray, following)

            # Both events before a jump at once
            if dr.hint(hurries, mode="scalar"):
                hurried = (passes | landed) & ~dead & (within != 0) & media.jumps(within)
                if hurried:
                    lots = [source.even(i, paths, sampler.next_1d(), begins) for i in sequence.STEP]
                    β, ratio, ray, planned, events, travelled = hurry(
                        scene, media, lamps, within, ray, β, ratio, channel, sigma_t, sigma_s, g,
                        [*lots, sampler.next_1d()], hurried,
                    )  # fmt: skip
                    steps, jumps = mi.UInt32(events), events == 2
                    order += events
                    thin, outside_yet = thin & (events == 0), outside_yet & (events == 0)

        # --- Jump, and its next chord --------------------------------------------------------------------------------
        if dr.hint(media.any_jump, mode="scalar"):
            if jumps:
                β, search = jump.take_over(media, within, sigma_t, sigma_s, β / dr.sum(ratio), initial, jumps)
                ratio = channels.solo(β)
            starts = search.active & (search.left == 0)
            if starts:
                place = media.kernels.place(within, sigma_t - sigma_s, sigma_s, g)
                search, ray.o, ray.d = jump.chord(
                    search, media.kernels, place, entry_p, entry_n, β, sampler, starts
                )

        # --- End: roulette on what is left ---------------------------------------------------------------------------
        worth = dr.max(β / dr.sum(ratio))
        walking = (within != 0) & ~jumps & ~searching
        spent = active & walking & (steps >= s.max_steps)
        cut[spent & ~dead] += worth
        survival = dr.select((depth > s.rr_depth) & (within == 0), dr.minimum(worth, 0.95), 1)
        survival = dr.select(walking, roulette.walking(worth, entered, mi.Float(events) * (1 - g)), survival)
        if dr.hint(media.any_jump, mode="scalar"):
            survival = dr.select(lit, dr.minimum(survival, roulette.lit(worth, initial / len(β))), survival)
        # lights have been connected to by all of what came through: from here on as many go on as would have come
        survival = dr.minimum(survival, dr.select(through & (within == 0), dr.max(along), 1))
        dead |= spent | ~(worth > 0) | (sampler.next_1d(active) >= survival)
        β /= survival
        dead &= active
        if dr.hint(repeats, mode="scalar"):
            if dead:
                source.put(position, L, ray.wavelengths, valid, dead)
            fresh = mi.Bool(dead)
            active &= ~(dead & (paths >= source.budget))
        else:
            active &= ~dead
    return Result(L, valid, cut, started)
