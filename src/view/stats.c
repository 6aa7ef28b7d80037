/* SPDX-License-Identifier: MIT */
#include "view/stats.h"

#include <math.h>
#include <stdio.h>

#include "view/clock.h"

void view_stats_add(view_stats *t, double ms)
{
    if (!t->frames)
        t->begun = view_clock() - 1e-3 * ms;
    t->frames++;
    t->sum += ms;
    t->worst = fmax(t->worst, ms);
}

/* The end of a line. */
static void print_frames(view_stats *t)
{
    printf(" frames=%d frame=%.1f worst=%.1f\n", t->frames, t->sum / t->frames,
           t->worst);
    t->frames = 0;
    t->sum = t->worst = 0;
}

static void print_probe(const view_scene *stage, const view_settings *s,
                        view_probe_filter filter)
{
    double ms[3];

    view_scene_times(stage, filter, ms);
    printf("probe seconds=%.3f size=%d capture=%s filter=%s ms=%.1f "
           "drawing=%.1f levels=%.1f irradiance=%.1f",
           view_scene_shown(stage), s->probe_size,
           view_probe_capture_names[s->probe_capture],
           view_probe_filter_names[filter], ms[0] + ms[1] + ms[2], ms[0], ms[1],
           ms[2]);
}

/* Of the scene its probe's last update. */
static void print_line(view_stats *t, const view_scene *stage,
                       const view_settings *s)
{
    if (s->mode == VIEW_SCENE)
        print_probe(stage, s, s->probe_filter);
    else
        printf("view mode=%s", view_mode_names[s->mode]);
    print_frames(t);
}

void view_stats_tell(view_stats *t, const view_renderer *r,
                     const view_settings *s)
{
    const view_scene *stage = view_renderer_stage(r);
    const int updates = stage ? view_scene_updates(stage) : 0;

    if (!t->frames || (s->mode == VIEW_SCENE ? updates == t->updates
                                             : view_clock() - t->begun < 1))
        return;
    t->updates = updates;
    print_line(t, stage, s);
    fflush(stdout);
}

bool view_stats_end(view_stats *t, const view_renderer *r,
                    const view_settings *s)
{
    view_scene *stage = view_renderer_stage(r);
    const view_probe_filter other =
        s->probe_filter == VIEW_PROBE_GPU ? VIEW_PROBE_CPU : VIEW_PROBE_GPU;

    print_line(t, stage, s);
    if (s->mode != VIEW_SCENE)
        return true;
    if (!view_scene_measure(stage, other))
        return false;
    print_probe(stage, s, other);
    putchar('\n');
    return true;
}
