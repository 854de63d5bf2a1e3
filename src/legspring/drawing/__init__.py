"""What figures and films are made of: a style, strokes, a stage, films; of datasets alone, which know no gait."""
