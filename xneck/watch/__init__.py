"""A recording watched while it grows. `watch.py` is the entry; it is made of these:

growing_file      the bytes of a file that another program writes
growing_video     the frames of a growing video, in the segments that `run` will cut it into
growing_log       the rows of a growing log: csv_rows, mcap_rows
finding           one thing that is wrong, and since when
video_watch       markers followed as the frames come; what of it `run` can go on from
marker_findings, light_findings, frame_findings, log_findings, motion_findings   what is looked for
outcome           the clock, and what will be identifiable
"""
